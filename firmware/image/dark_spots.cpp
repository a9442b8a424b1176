#include "image/dark_spots.h"

#include <algorithm>
#include <cstring>

#include "base/contract.h"
#include "base/vector_clones.h"

// A maximum over n neighbours is a maximum over two or three overlapping maxima of four: two passes, whatever the
// picture says. The loops are plain, without branches and on bytes, so that the compiler turns each into vector
// instructions.

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

/// out[i] = the extreme of all rows at i.
template <typename Pick, typename... Rows>
void combine(Pick pick, int count, std::uint8_t* __restrict out, const std::uint8_t* first,
             const Rows*... others) noexcept {
  for (int i = 0; i < count; ++i) {
    std::uint8_t extreme = first[i];
    ((extreme = pick(extreme, others[i])), ...);
    out[i] = extreme;
  }
}

/// The same of kWindow rows, of which fours(i) is the extreme of the rows i, i + 1, i + 2 and i + 3.
template <int kWindow, typename Pick, typename Fours>
void combine_fours(Pick pick, int count, std::uint8_t* out, Fours&& fours) noexcept {
  static_assert(kWindow >= 4 && kWindow <= 12);
  if constexpr (kWindow <= 8)
    combine(pick, count, out, fours(0), fours(kWindow - 4));
  else
    combine(pick, count, out, fours(0), fours(4), fours(kWindow - 4));
}

/// out[x] = extreme of in[x - kLeft .. x + kRight] along a row; outside the row counts as nothing.
template <int kLeft, int kRight, typename Pick>
void slide_along_row(const std::uint8_t* in, std::uint8_t* out, std::uint8_t* line, std::uint8_t* fours, int width,
                     Pick pick) noexcept {
  const int padded = width + kLeft + kRight;
  std::memset(line, Pick::kNeutral, kLeft);
  std::memcpy(line + kLeft, in, static_cast<std::size_t>(width));
  std::memset(line + kLeft + width, Pick::kNeutral, kRight);
  combine(pick, padded - 3, fours, line, line + 1, line + 2, line + 3);
  combine_fours<kLeft + kRight + 1>(pick, width, out, [&](int i) { return fours + i; });
}

/// The same along columns: a ring of row pointers would save memory, whole pictures are simpler and fit the cache.
template <int kAbove, int kBelow, typename Pick>
void slide_along_columns(const ImageBuffer& in, ImageBuffer& out, ImageBuffer& fours, Pick pick) noexcept {
  const int width = in.width_px();
  const int height = in.height_px();
  const auto source = [&](int y) { return in.row(std::clamp(y, 0, height - 1)); };
  for (int y = -kAbove; y + 3 < height + kBelow; ++y)
    combine(pick, width, fours.row(y + kAbove), source(y), source(y + 1), source(y + 2), source(y + 3));
  for (int y = 0; y < height; ++y)
    combine_fours<kAbove + kBelow + 1>(pick, width, out.row(y), [&](int i) { return fours.row(y + i); });
}

}  // namespace

SpotThreshold::SpotThreshold(int max_half_width_px, int max_half_height_px)
    : scratch_(max_half_width_px, max_half_height_px),
      dilated_(max_half_width_px, max_half_height_px),
      closed_(max_half_width_px, max_half_height_px),
      eroded_(max_half_width_px, max_half_height_px),
      fours_(max_half_width_px, max_half_height_px + kSquare_px),
      line_{ImageBuffer(max_half_width_px, 1), ImageBuffer(max_half_width_px, 1)} {}

NINEDOT_VECTOR_CLONES
const ImageBuffer& SpotThreshold::compute(const ImageView& half, int min_contrast_lsb) noexcept {
  const int width = half.width_px;
  const int height = half.height_px;
  for (ImageBuffer* buffer : {&scratch_, &dilated_, &closed_, &eroded_}) buffer->resize_within(width, height);
  std::uint8_t* line = line_[0].row(0);
  std::uint8_t* fours = line_[1].row(0);

  for (int y = 0; y < height; ++y)
    slide_along_row<kBefore, kAfter>(half.row(y), scratch_.row(y), line, fours, width, Maximum{});
  slide_along_columns<kBefore, kAfter>(scratch_, dilated_, fours_, Maximum{});
  // The erosion's window is the dilation's mirrored: only then is the closing nowhere darker than the picture.
  for (int y = 0; y < height; ++y)
    slide_along_row<kAfter, kBefore>(dilated_.row(y), scratch_.row(y), line, fours, width, Minimum{});
  slide_along_columns<kAfter, kBefore>(scratch_, closed_, fours_, Minimum{});

  for (int y = 0; y < height; ++y)
    slide_along_row<kInkReach_px, kInkReach_px>(half.row(y), scratch_.row(y), line, fours, width, Minimum{});
  slide_along_columns<kInkReach_px, kInkReach_px>(scratch_, eroded_, fours_, Minimum{});

  const auto least = static_cast<std::uint8_t>(std::clamp(min_contrast_lsb, 0, 255));
  std::uint8_t darkest = 255;
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* row = eroded_.row(y);
    for (int x = 0; x < width; ++x) darkest = row[x] < darkest ? row[x] : darkest;
  }
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* __restrict paper = closed_.row(y);
    const std::uint8_t* __restrict ink = eroded_.row(y);
    std::uint8_t* __restrict threshold = scratch_.row(y);
    // On bytes throughout: the average that rounds up is one instruction.
    for (int x = 0; x < width; ++x) {
      const auto contrast = static_cast<std::uint8_t>(paper[x] - ink[x]);  // the closing is nowhere darker
      const auto middle = static_cast<std::uint8_t>((paper[x] + ink[x] + 1) >> 1);
      const auto of_paper = static_cast<std::uint8_t>(paper[x] / SpotThreshold::kMinContrastShare);
      const auto above_darkest = static_cast<std::uint8_t>(paper[x] - darkest);
      const auto of_range = static_cast<std::uint8_t>(above_darkest - above_darkest / SpotThreshold::kMaxRangeLeft);
      const std::uint8_t share = of_paper < of_range ? of_paper : of_range;
      const std::uint8_t needed = share > least ? share : least;
      threshold[x] = contrast >= needed ? middle : std::uint8_t{0};
    }
  }
  return scratch_;
}

}  // namespace ninedot
