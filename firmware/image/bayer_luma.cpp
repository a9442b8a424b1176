#include "image/bayer_luma.h"

#include <algorithm>
#include <cstddef>

namespace ninedot {
namespace {

// With whole chroma 0.271 Cb makes (R + 2 G + B) / 4 of luma. Chroma is averaged over two pixels each way, and so has
// less of what is to be cancelled: of 0 to 0.7 Cb and -0.2 to 0.2 Cr these left least, over dots of 2.7 px of all four
// inks (0.04 instead of 0.063 px) and of P9. In LSB/64.
constexpr int kCb = 32, kCr = -6, kShift = 6, kScale = 1 << kShift;
constexpr int kNoColour = 128;

}  // namespace

BayerLuma::BayerLuma(int width_px, int height_px)
    : width_px_(width_px),
      height_px_(height_px),
      pixels_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)),
      weighed_(static_cast<std::size_t>(width_px) + 2),
      spread_(static_cast<std::size_t>(width_px)) {}

/// Of the chroma at a row of pixels, between the two nearest rows of chroma: a triangle as wide as a sample is high,
/// two pixels at least. One sample more to either side, as the outermost one is.
void BayerLuma::weigh_row(const ImageView& luma, const ChromaView& chroma, int y) noexcept {
  const int block = (luma.height_px + chroma.height - 1) / chroma.height, row = y / block;
  // Weights of the row above, this one and the one below, in quarters.
  const bool upper = y % block * 2 < block - 1;
  const int above = block == 1 || upper ? 1 : 0, below = block == 1 || !upper ? 1 : 0, here = 4 - above - below;
  const auto at = [&](int r, int x) {
    const std::ptrdiff_t i = std::clamp(r, 0, chroma.height - 1) * chroma.stride_bytes + x * chroma.step_bytes;
    return kCb * (chroma.cb[i] - kNoColour) + kCr * (chroma.cr[i] - kNoColour);
  };
  for (int x = 0; x < chroma.width; ++x)
    weighed_[static_cast<std::size_t>(x) + 1] =
        static_cast<std::int16_t>((above * at(row - 1, x) + here * at(row, x) + below * at(row + 1, x)) / 4);
  weighed_[0] = weighed_[1];
  weighed_[static_cast<std::size_t>(chroma.width) + 1] = weighed_[static_cast<std::size_t>(chroma.width)];
}

void BayerLuma::spread_row(int columns, int width_px) noexcept {
  const int block = (width_px + columns - 1) / columns;
  const std::int16_t* w = weighed_.data() + 1;
  if (block == 1) {
    for (int x = 0; x < width_px; ++x)
      spread_[static_cast<std::size_t>(x)] = static_cast<std::int16_t>((w[x - 1] + 2 * w[x] + w[x + 1]) / 4);
    return;
  }
  for (int x = 0; x < width_px; ++x) {
    const int i = x / block, beside = x % block * 2 < block - 1 ? i - 1 : i + 1;
    spread_[static_cast<std::size_t>(x)] = static_cast<std::int16_t>((3 * w[i] + w[beside]) / 4);
  }
}

ImageView BayerLuma::of(const ImageView& luma, const ChromaView& chroma) noexcept {
  if (chroma.luma_is_balanced || luma.width_px > width_px_ || luma.height_px > height_px_ || chroma.empty() ||
      chroma.width <= 0 || chroma.height <= 0 || chroma.width > luma.width_px || chroma.height > luma.height_px)
    return luma;
  for (int y = 0; y < luma.height_px; ++y) {
    weigh_row(luma, chroma, y);
    spread_row(chroma.width, luma.width_px);
    std::uint8_t* to = pixels_.data() + std::ptrdiff_t{y} * luma.width_px;
    const std::uint8_t* from = luma.row(y);
    for (int x = 0; x < luma.width_px; ++x) {
      const int level = from[x] + ((spread_[static_cast<std::size_t>(x)] + kScale / 2) >> kShift);
      to[x] = static_cast<std::uint8_t>(std::clamp(level, 0, 255));
    }
  }
  return {pixels_.data(), luma.width_px, luma.height_px, luma.width_px};
}

}  // namespace ninedot
