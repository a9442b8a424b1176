#include "drivers/camera/bayer.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

enum Colour : std::size_t { kRed, kGreen, kBlue };

std::uint8_t to_byte(double value) noexcept { return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)); }

/// Calls use(x, sample) for each sample of a row.
template <typename Use>
void for_samples(const BayerLayout& layout, const std::uint8_t* row, std::size_t width, Use use) noexcept {
  using Packing = BayerLayout::Packing;
  if (layout.packing == Packing::kBytes) {
    for (std::size_t x = 0; x < width; ++x) use(x, unsigned{row[x]});
  } else if (layout.packing == Packing::kWords) {
    const unsigned most = (1U << layout.bits) - 1;  // the bits above are none of ours, and drivers leave them 0
    for (std::size_t x = 0; x < width; ++x) use(x, (row[2 * x] | unsigned{row[2 * x + 1]} << 8U) & most);
  } else if (layout.bits == 10) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint8_t* const group = row + x / 4 * 5;
      use(x, unsigned{group[x % 4]} << 2U | ((unsigned{group[4]} >> (2 * (x % 4))) & 3U));
    }
  } else {
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint8_t* const group = row + x / 2 * 3;
      use(x, unsigned{group[x % 2]} << 4U | ((unsigned{group[2]} >> (4 * (x % 2))) & 15U));
    }
  }
}

}  // namespace

BayerDeveloper::BayerDeveloper(const BayerLayout& layout, const BayerBalance& balance, int width_px, int height_px)
    : layout_(layout), width_(static_cast<std::size_t>(width_px)), height_(static_cast<std::size_t>(height_px)) {
  EXPECTS(width_px >= 2 && height_px >= 2);
  EXPECTS(layout.bits == 8 || layout.bits == 10 || layout.bits == 12);
  const double largest = (1U << layout.bits) - 1;
  EXPECTS(balance.black_level >= 0 && balance.black_level < largest);
  const double gains[] = {balance.red_gain, 1, balance.blue_gain};
  for (const Colour colour : {kRed, kGreen, kBlue}) {
    light_[colour].fill(0);
    for (std::size_t i = 0; i <= static_cast<std::size_t>(largest); ++i) {
      const double share = (static_cast<double>(i) - balance.black_level) / (largest - balance.black_level);
      light_[colour][i] = static_cast<std::uint16_t>(std::lround(kWhite * std::clamp(gains[colour] * share, 0.0, 1.0)));
    }
  }
  for (std::size_t i = 0; i <= kWhite; ++i) tone_[i] = to_byte(255 * std::sqrt(static_cast<double>(i) / kWhite));
  for (auto& row : rows_) row.resize(width_ + 2);
}

/// \param y  -1 and height are the mirrored ones \param light  the row's pixel -1
void BayerDeveloper::read_row(const std::uint8_t* mosaic, std::size_t stride_bytes, std::ptrdiff_t y,
                              std::uint16_t* light) noexcept {
  const auto height = static_cast<std::ptrdiff_t>(height_);
  const auto mirrored = static_cast<std::size_t>(y < 0 ? -y : y < height ? y : 2 * height - 2 - y);
  const bool has_red = static_cast<int>(mirrored % 2) == layout_.red_y;
  const auto red_x = static_cast<std::size_t>(layout_.red_x);
  // A row has green and one other: red in its column, or blue in the other one.
  const LightTable& other = light_[has_red ? kRed : kBlue];
  const std::size_t other_x = has_red ? red_x : 1 - red_x;
  for_samples(layout_, mosaic + mirrored * stride_bytes, width_, [&](std::size_t x, unsigned sample) {
    light[x + 1] = (x % 2 == other_x ? other : light_[kGreen])[sample];
  });
  light[0] = light[2];
  light[width_ + 1] = light[width_ - 1];
}

void BayerDeveloper::write_luma(const std::uint16_t* above, const std::uint16_t* here, const std::uint16_t* below,
                                std::uint8_t* luma) const noexcept {
  const auto column = [&](std::size_t x) { return unsigned{above[x]} + 2U * here[x] + below[x]; };
  for (std::size_t x = 0; x < width_; ++x) luma[x] = tone_[(column(x) + 2U * column(x + 1) + column(x + 2) + 8U) >> 4U];
}

/// \param even, odd  the cells' upper and lower row
void BayerDeveloper::write_chroma(const std::uint16_t* even, const std::uint16_t* odd,
                                  std::uint8_t* chroma) const noexcept {
  const std::uint16_t* const with_red = layout_.red_y == 0 ? even : odd;
  const std::uint16_t* const with_blue = layout_.red_y == 0 ? odd : even;
  const auto red_x = static_cast<std::size_t>(layout_.red_x), blue_x = 1 - red_x;
  for (std::size_t x = 1; x < width_ + 1; x += 2, chroma += 2) {
    const float red = tone_[with_red[x + red_x]], blue = tone_[with_blue[x + blue_x]];
    const float green = tone_[(with_red[x + blue_x] + with_blue[x + red_x] + 1U) / 2U];
    const float grey = 0.299F * red + 0.587F * green + 0.114F * blue;
    chroma[0] = to_byte(128 + 0.564F * (blue - grey));
    chroma[1] = to_byte(128 + 0.713F * (red - grey));
  }
}

void BayerDeveloper::develop(const std::uint8_t* mosaic, std::size_t stride_bytes, std::uint8_t* picture) noexcept {
  std::uint8_t* luma = picture;
  std::uint8_t* chroma = picture + luma_bytes();
  read_row(mosaic, stride_bytes, -1, rows_[0].data());
  read_row(mosaic, stride_bytes, 0, rows_[1].data());
  for (std::size_t y = 0; y < height_; ++y, luma += width_) {
    const std::uint16_t* const above = rows_[y % 3].data();
    const std::uint16_t* const here = rows_[(y + 1) % 3].data();
    std::uint16_t* const below = rows_[(y + 2) % 3].data();
    read_row(mosaic, stride_bytes, static_cast<std::ptrdiff_t>(y) + 1, below);
    write_luma(above, here, below, luma);
    if (y % 2 != 0) continue;
    write_chroma(here, below, chroma);
    chroma += 2 * cells_across();
  }
}

ChromaView BayerDeveloper::chroma_of(const std::uint8_t* picture) const noexcept {
  const std::uint8_t* const chroma = picture + luma_bytes();
  const auto across = static_cast<int>(cells_across());
  return {chroma, chroma + 1, across, static_cast<int>(cells_down()), 2, 2 * std::ptrdiff_t{across}};
}

std::size_t bayer_row_bytes(const BayerLayout& layout, std::size_t width_px) noexcept {
  if (layout.packing == BayerLayout::Packing::kBytes) return width_px;
  if (layout.packing == BayerLayout::Packing::kWords) return 2 * width_px;
  return layout.bits == 10 ? (width_px + 3) / 4 * 5 : (width_px + 1) / 2 * 3;
}

}  // namespace ninedot
