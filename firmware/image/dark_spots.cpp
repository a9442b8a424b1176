#include "image/dark_spots.h"

#include <algorithm>
#include <cstring>

#include "base/contract.h"

// A maximum over n neighbours is a maximum over two overlapping maxima of n/2: log2(n) passes, whatever the picture
// says. The loops are plain, without branches and on bytes, so that the compiler turns each into vector instructions.

namespace ninedot {
namespace {

struct Maximum {
  static constexpr std::uint8_t kNeutral = 0;
  std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const noexcept { return a > b ? a : b; }
};
struct Minimum {
  static constexpr std::uint8_t kNeutral = 255;
  std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const noexcept { return a < b ? a : b; }
};

constexpr int kBefore = SpotThreshold::kSquare_px / 2;           // of the window, left of and above its pixel
constexpr int kAfter = SpotThreshold::kSquare_px - kBefore - 1;  // right of and below it

template <typename Pick>
void combine(const std::uint8_t* __restrict a, const std::uint8_t* __restrict b, std::uint8_t* __restrict out,
             int count, Pick pick) noexcept {
  for (int i = 0; i < count; ++i) out[i] = pick(a[i], b[i]);
}

/// out[x] = extreme of in[x - before .. x + after] along a row; outside the row counts as nothing.
template <typename Pick>
void slide_along_row(const std::uint8_t* in, std::uint8_t* out, std::uint8_t* line_a, std::uint8_t* line_b, int width,
                     int before, int after, Pick pick) noexcept {
  const int window = before + after + 1;
  const int padded = width + window - 1;
  std::memset(line_a, Pick::kNeutral, static_cast<std::size_t>(padded + 1));
  std::memcpy(line_a + before, in, static_cast<std::size_t>(width));
  int span = 1;
  while (span * 2 <= window) {
    combine(line_a, line_a + span, line_b, padded - 2 * span + 1, pick);
    std::swap(line_a, line_b);
    span *= 2;
  }
  combine(line_a, line_a + (window - span), out, width, pick);
}

/// The same along columns: a ring of row pointers would save memory, whole pictures are simpler and fit the cache.
template <typename Pick>
void slide_along_columns(const ImageBuffer& in, ImageBuffer& out, ImageBuffer& a, ImageBuffer& b, int before, int after,
                         Pick pick) noexcept {
  const int width = in.width_px();
  const int height = in.height_px();
  const int window = before + after + 1;
  // In row coordinates of the padded picture (row r of it is row r - before of `in`).
  const int padded = height + window - 1;
  const auto source = [&](int r) { return in.row(std::clamp(r - before, 0, height - 1)); };
  int span = 1;
  const ImageBuffer* from = nullptr;
  ImageBuffer* to = &a;
  while (span * 2 <= window) {
    for (int r = 0; r + 2 * span <= padded; ++r) {
      const std::uint8_t* first = from == nullptr ? source(r) : from->row(r);
      const std::uint8_t* second = from == nullptr ? source(r + span) : from->row(r + span);
      combine(first, second, to->row(r), width, pick);
    }
    from = to;
    to = to == &a ? &b : &a;
    span *= 2;
  }
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* first = from == nullptr ? source(y) : from->row(y);
    const std::uint8_t* second = from == nullptr ? source(y + window - span) : from->row(y + window - span);
    combine(first, second, out.row(y), width, pick);
  }
}

}  // namespace

SpotThreshold::SpotThreshold(int max_half_width_px, int max_half_height_px)
    : scratch_(max_half_width_px, max_half_height_px),
      dilated_(max_half_width_px, max_half_height_px),
      closed_(max_half_width_px, max_half_height_px),
      eroded_(max_half_width_px, max_half_height_px),
      strip_{ImageBuffer(max_half_width_px, max_half_height_px + kSquare_px),
             ImageBuffer(max_half_width_px, max_half_height_px + kSquare_px), ImageBuffer(max_half_width_px, 1),
             ImageBuffer(max_half_width_px, 1)} {}

const ImageBuffer& SpotThreshold::compute(const ImageView& half, int min_contrast_lsb) noexcept {
  const int width = half.width_px;
  const int height = half.height_px;
  for (ImageBuffer* buffer : {&scratch_, &dilated_, &closed_, &eroded_}) buffer->resize_within(width, height);
  std::uint8_t* line_a = strip_[2].row(0);
  std::uint8_t* line_b = strip_[3].row(0);

  for (int y = 0; y < height; ++y)
    slide_along_row(half.row(y), scratch_.row(y), line_a, line_b, width, kBefore, kAfter, Maximum{});
  slide_along_columns(scratch_, dilated_, strip_[0], strip_[1], kBefore, kAfter, Maximum{});
  // The erosion's window is the dilation's mirrored: only then is the closing nowhere darker than the picture.
  for (int y = 0; y < height; ++y)
    slide_along_row(dilated_.row(y), scratch_.row(y), line_a, line_b, width, kAfter, kBefore, Minimum{});
  slide_along_columns(scratch_, closed_, strip_[0], strip_[1], kAfter, kBefore, Minimum{});

  for (int y = 0; y < height; ++y)
    slide_along_row(half.row(y), scratch_.row(y), line_a, line_b, width, kInkReach_px, kInkReach_px, Minimum{});
  slide_along_columns(scratch_, eroded_, strip_[0], strip_[1], kInkReach_px, kInkReach_px, Minimum{});

  const auto least = static_cast<std::uint8_t>(std::clamp(min_contrast_lsb, 0, 255));
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* __restrict paper = closed_.row(y);
    const std::uint8_t* __restrict ink = eroded_.row(y);
    std::uint8_t* __restrict threshold = scratch_.row(y);
    // On bytes throughout: the average that rounds up is one instruction.
    for (int x = 0; x < width; ++x) {
      const auto contrast = static_cast<std::uint8_t>(paper[x] - ink[x]);  // the closing is nowhere darker
      const auto middle = static_cast<std::uint8_t>((paper[x] + ink[x] + 1) >> 1);
      const auto share = static_cast<std::uint8_t>(paper[x] / SpotThreshold::kMinContrastShare);
      const std::uint8_t needed = share > least ? share : least;
      threshold[x] = contrast >= needed ? middle : std::uint8_t{0};
    }
  }
  return scratch_;
}

}  // namespace ninedot
