// Red and blue are rounded from the inverse of the header's equations, and green is what then gives the luma exactly.
// Nearly always the colour is met at once; otherwise red and blue a step or two off do it.
#include "drivers/picture/ycbcr.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "base/contract.h"

namespace ninedot {
namespace {

/// Steps that red and blue may be off the rounded inverse. One is enough to meet every colour that some R, G, B has
/// with its luma, and a luma for all others: the test Ycbcr.* goes through all of them.
constexpr int kReach = 1;

// 16-bit fixed point: R - Y = 1.402 (Cr - 128), B - Y = 1.772 (Cb - 128).
constexpr int kRedPerCr = 91881, kBluePerCb = 116130;
constexpr int kRedWeight = 19595, kGreenWeight = 38470, kBlueWeight = 7471;  // luma_from_rgb

constexpr int rounded(int fixed) noexcept { return (fixed + 32768) >> 16; }
constexpr bool is_level(int value) noexcept { return value >= 0 && value <= 255; }

/// The least green whose luma with these two is y: green times its weight has to reach this bound.
constexpr int green_bound(int y, int r, int b) noexcept { return 65536 * y - 32768 - kRedWeight * r - kBlueWeight * b; }
/// Nearest to the exact green: in the middle of those that give y.
constexpr int green_of(int y, int r, int b) noexcept {
  // Shifted to be positive for the division, which would round towards zero.
  return (green_bound(y, r, b) + 32768 + kGreenWeight / 2 + 256 * kGreenWeight) / kGreenWeight - 256;
}

struct Choice {
  Rgb rgb;
  int error = 1 << 20;  // squared distance of the colour
};

void consider(int y, int cb, int cr, int r, int g, int b, Choice& best) noexcept {
  if (!is_level(r) || !is_level(g) || !is_level(b)) return;
  const Rgb rgb{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)};
  if (luma_from_rgb(rgb.r, rgb.g, rgb.b) != y) return;
  const int off_cb = cb_from_rgb(rgb.r, rgb.g, rgb.b) - cb, off_cr = cr_from_rgb(rgb.r, rgb.g, rgb.b) - cr;
  if (const int error = off_cb * off_cb + off_cr * off_cr; error < best.error) best = {rgb, error};
}

void consider_around(int y, int cb, int cr, int r0, int b0, Choice& best) noexcept {
  for (int r = r0 - kReach; r <= r0 + kReach; ++r)
    for (int b = b0 - kReach; b <= b0 + kReach; ++b)
      for (int g = green_of(y, r, b) - 1; g <= green_of(y, r, b) + 1; ++g) consider(y, cb, cr, r, g, b, best);
}

/// How far, in 1/65536, a channel may go from y by `step` at full colour before it leaves 0..255; at most all the way.
constexpr std::int64_t share_within(int y, std::int64_t step) noexcept {
  const std::int64_t room = (step > 0 ? 255 - y : y) * std::int64_t{65536};
  const std::int64_t size = step > 0 ? step : -step;
  return size <= room ? 65536 : room * 65536 / size;
}

Rgb search(int y, int cb, int cr) noexcept {
  const std::int64_t red = std::int64_t{kRedPerCr} * (cr - 128), blue = std::int64_t{kBluePerCb} * (cb - 128);
  const std::int64_t green = -(kRedWeight * red + kBlueWeight * blue) / kGreenWeight;
  // Out of range: towards grey, which keeps the hue, until all three are within it.
  const std::int64_t share = std::min({share_within(y, red), share_within(y, green), share_within(y, blue)});
  const int r0 = y + rounded(static_cast<int>(red * share / 65536));
  const int b0 = y + rounded(static_cast<int>(blue * share / 65536));
  Choice best;
  consider_around(y, cb, cr, r0, b0, best);
  // At the very edge of the range rounding may let in a colour that the exact equations keep out.
  if (best.error != 0 && share < 65536)
    consider_around(y, cb, cr, std::clamp(y + rounded(static_cast<int>(red)), 0, 255),
                    std::clamp(y + rounded(static_cast<int>(blue)), 0, 255), best);
  return best.rgb;
}

}  // namespace

Rgb rgb_from_ycbcr(std::uint8_t y, std::uint8_t cb, std::uint8_t cr) noexcept {
  const int r = y + rounded(kRedPerCr * (cr - 128)), b = y + rounded(kBluePerCb * (cb - 128));
  Choice direct;
  if (is_level(r) && is_level(b)) consider(y, cb, cr, r, green_of(y, r, b), b, direct);
  return direct.error == 0 ? direct.rgb : search(y, cb, cr);
}

void rgb_from_ycbcr(const ImageView& luma, const ChromaView& chroma, std::span<std::uint8_t> rgb) noexcept {
  EXPECTS(rgb.size() == 3 * static_cast<std::size_t>(luma.width_px) * static_cast<std::size_t>(luma.height_px));
  EXPECTS(!chroma.empty() && chroma.width > 0 && chroma.height > 0);
  const int columns = (luma.width_px + chroma.width - 1) / chroma.width;
  const int rows = (luma.height_px + chroma.height - 1) / chroma.height;
  std::uint8_t* to = rgb.data();
  for (int y = 0; y < luma.height_px; ++y) {
    const int sample_y = std::min(y / rows, chroma.height - 1);
    for (int x = 0; x < luma.width_px; ++x) {
      // A pixel left over at the end of a row (YUYV of an odd width) has the colour of its neighbour.
      const int sample_x = std::min(x / columns, chroma.width - 1);
      const Rgb pixel =
          rgb_from_ycbcr(luma.at(x, y), chroma.cb_at(sample_x, sample_y), chroma.cr_at(sample_x, sample_y));
      *to++ = pixel.r, *to++ = pixel.g, *to++ = pixel.b;
    }
  }
}

void chroma_from_rgb(std::span<const std::uint8_t> rgb, std::uint8_t* cb, std::uint8_t* cr) noexcept {
  for (std::size_t i = 0; 3 * i + 2 < rgb.size(); ++i) {
    cb[i] = cb_from_rgb(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]);
    cr[i] = cr_from_rgb(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]);
  }
}

}  // namespace ninedot
