#include "image/bayer_luma.h"

#include <algorithm>
#include <cstddef>
#include <opencv2/core/hal/intrin.hpp>
#include <utility>

// Row by row, eight values at a time: what is left of a row is done one by one, by the same formulas.

namespace ninedot {
namespace {

// With whole chroma 0.271 Cb makes (R + 2 G + B) / 4 of luma. Chroma is averaged over two pixels each way, and so has
// less of what is to be cancelled: of 0 to 0.7 Cb and -0.2 to 0.2 Cr these left least, over dots of 2.7 px of all four
// inks (0.04 instead of 0.063 px) and of P9. In LSB/64.
constexpr int kCb = 32, kCr = -6, kShift = 6, kScale = 1 << kShift;
constexpr int kNoColour = 128;

constexpr int kLanes = 8;
using Lanes = cv::v_int16x8;

Lanes times(Lanes values, int factor) noexcept {
  return cv::v_mul_wrap(values, cv::v_setall_s16(static_cast<short>(factor)));
}
template <typename... More>
Lanes sum(Lanes first, More... others) noexcept {
  ((first = cv::v_add_wrap(first, others)), ...);
  return first;
}
/// Of sixteen bytes the first or the last eight.
Lanes low(cv::v_uint8x16 bytes) noexcept { return cv::v_reinterpret_as_s16(cv::v_expand_low(bytes)); }
Lanes high(cv::v_uint8x16 bytes) noexcept { return cv::v_reinterpret_as_s16(cv::v_expand_high(bytes)); }

int weigh(int cb, int cr) noexcept { return kCb * (cb - kNoColour) + kCr * (cr - kNoColour); }
Lanes weigh(Lanes cb, Lanes cr) noexcept {
  return sum(times(cb, kCb), times(cr, kCr), cv::v_setall_s16(-kNoColour * (kCb + kCr)));
}

std::int16_t quarter(int fours) noexcept { return static_cast<std::int16_t>((fours + 2) >> 2); }
Lanes quarter(Lanes fours) noexcept { return cv::v_shr<2>(sum(fours, cv::v_setall_s16(2))); }

}  // namespace

BayerLuma::BayerLuma(int width_px, int height_px)
    : width_px_(width_px),
      height_px_(height_px),
      pixels_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)),
      mixed_(static_cast<std::size_t>(width_px) + 2),
      spread_(static_cast<std::size_t>(width_px)) {
  weighed_.fill(std::vector<std::int16_t>(static_cast<std::size_t>(width_px)));
}

/// Beyond the picture's border as at it. Rows are asked for from above to below, at most two apart.
const std::int16_t* BayerLuma::weighed_row(const ChromaView& chroma, int row) noexcept {
  const int r = std::clamp(row, 0, chroma.height - 1);
  const auto slot = static_cast<std::size_t>(r) % weighed_.size();
  std::int16_t* weighed = weighed_[slot].data();
  if (weighed_row_[slot] == r) return weighed;
  weighed_row_[slot] = r;
  const std::uint8_t* cb = chroma.cb + std::ptrdiff_t{r} * chroma.stride_bytes;
  const std::uint8_t* cr = chroma.cr + std::ptrdiff_t{r} * chroma.stride_bytes;
  int x = 0;
  if (chroma.step_bytes == 1) {
    for (; x + 2 * kLanes <= chroma.width; x += 2 * kLanes) {
      const cv::v_uint8x16 b = cv::v_load(cb + x), r16 = cv::v_load(cr + x);
      cv::v_store(weighed + x, weigh(low(b), low(r16)));
      cv::v_store(weighed + x + kLanes, weigh(high(b), high(r16)));
    }
  } else if (chroma.step_bytes == 2 && (cr == cb + 1 || cb == cr + 1)) {
    for (; x + 2 * kLanes <= chroma.width; x += 2 * kLanes) {
      cv::v_uint8x16 first, second;
      cv::v_load_deinterleave(std::min(cb, cr) + std::ptrdiff_t{2} * x, first, second);
      if (cr < cb) std::swap(first, second);
      cv::v_store(weighed + x, weigh(low(first), low(second)));
      cv::v_store(weighed + x + kLanes, weigh(high(first), high(second)));
    }
  }
  for (; x < chroma.width; ++x) {
    const std::ptrdiff_t at = std::ptrdiff_t{x} * chroma.step_bytes;
    weighed[x] = static_cast<std::int16_t>(weigh(cb[at], cr[at]));
  }
  return weighed;
}

/// Of the chroma at a row of pixels, between the two nearest rows of chroma: a triangle as wide as a sample is high,
/// two pixels at least. One sample more to either side, as the outermost one is.
void BayerLuma::mix_rows(const ChromaView& chroma, int block, int y) noexcept {
  const int row = y / block;
  // Weights of the row above, this one and the one below, in quarters.
  const bool upper = y % block * 2 < block - 1;
  const int above = block == 1 || upper ? 1 : 0, below = block == 1 || !upper ? 1 : 0, here = 4 - above - below;
  const std::int16_t* __restrict over = weighed_row(chroma, row - 1);
  const std::int16_t* __restrict at = weighed_row(chroma, row);
  const std::int16_t* __restrict under = weighed_row(chroma, row + 1);
  std::int16_t* __restrict mixed = mixed_.data() + 1;
  int x = 0;
  for (; x + kLanes <= chroma.width; x += kLanes) {
    const Lanes fours =
        sum(times(cv::v_load(over + x), above), times(cv::v_load(at + x), here), times(cv::v_load(under + x), below));
    cv::v_store(mixed + x, quarter(fours));
  }
  for (; x < chroma.width; ++x) mixed[x] = quarter(above * over[x] + here * at[x] + below * under[x]);
  mixed[-1] = mixed[0];
  mixed[chroma.width] = mixed[chroma.width - 1];
}

void BayerLuma::spread_row(int columns, int width_px) noexcept {
  const int block = (width_px + columns - 1) / columns;
  const std::int16_t* __restrict w = mixed_.data() + 1;
  std::int16_t* __restrict spread = spread_.data();
  int x = 0;
  if (block == 1) {
    for (; x + kLanes <= width_px; x += kLanes)
      cv::v_store(spread + x, quarter(sum(cv::v_load(w + x - 1), times(cv::v_load(w + x), 2), cv::v_load(w + x + 1))));
    for (; x < width_px; ++x) spread[x] = quarter(w[x - 1] + 2 * w[x] + w[x + 1]);
    return;
  }
  if (block == 2) {  // nearly every camera's
    for (; x + 2 * kLanes <= width_px; x += 2 * kLanes) {
      const Lanes thrice = times(cv::v_load(w + x / 2), 3);
      cv::v_store_interleave(spread + x, quarter(sum(thrice, cv::v_load(w + x / 2 - 1))),
                             quarter(sum(thrice, cv::v_load(w + x / 2 + 1))));
    }
  }
  for (; x < width_px; ++x) {
    const int i = x / block, beside = x % block * 2 < block - 1 ? i - 1 : i + 1;
    spread[x] = quarter(3 * w[i] + w[beside]);
  }
}

ImageView BayerLuma::of(const ImageView& luma, const ChromaView& chroma) noexcept {
  if (chroma.luma_is_balanced || luma.width_px > width_px_ || luma.height_px > height_px_ || chroma.empty() ||
      chroma.width <= 0 || chroma.height <= 0 || chroma.width > luma.width_px || chroma.height > luma.height_px)
    return luma;
  const int block = (luma.height_px + chroma.height - 1) / chroma.height;
  weighed_row_.fill(-1);
  for (int y = 0; y < luma.height_px; ++y) {
    mix_rows(chroma, block, y);
    spread_row(chroma.width, luma.width_px);
    std::uint8_t* __restrict to = pixels_.data() + std::ptrdiff_t{y} * luma.width_px;
    const std::uint8_t* __restrict from = luma.row(y);
    const std::int16_t* __restrict add = spread_.data();
    int x = 0;
    const auto rounded = [&](const std::int16_t* values) {
      return cv::v_shr<kShift>(sum(cv::v_load(values), cv::v_setall_s16(kScale / 2)));
    };
    for (; x + 2 * kLanes <= luma.width_px; x += 2 * kLanes) {
      const cv::v_uint8x16 levels = cv::v_load(from + x);
      cv::v_store(to + x,
                  cv::v_pack_u(sum(low(levels), rounded(add + x)), sum(high(levels), rounded(add + x + kLanes))));
    }
    for (; x < luma.width_px; ++x) {
      const int level = from[x] + ((add[x] + kScale / 2) >> kShift);
      to[x] = static_cast<std::uint8_t>(std::clamp(level, 0, 255));
    }
  }
  return {pixels_.data(), luma.width_px, luma.height_px, luma.width_px};
}

}  // namespace ninedot
