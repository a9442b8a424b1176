#pragma once
/// Between R, G, B and Y, Cb, Cr of 8 bits each: ITU-R BT.601 with the full range of levels, as JPEG (JFIF 1.02) has
/// it.
///
///     Y  =        0.299    R + 0.587    G + 0.114    B
///     Cb = 128 -  0.168736 R - 0.331264 G + 0.5      B
///     Cr = 128 +  0.5      R - 0.418688 G - 0.081312 B
///
/// Memory: none. Threads: pure.
#include <cstdint>
#include <span>

#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;  ///< 0..255
};

/// 16-bit fixed-point weights that sum to one: white stays 255, rounded to nearest.
constexpr std::uint8_t luma_from_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) noexcept {
  return static_cast<std::uint8_t>((19595U * r + 38470U * g + 7471U * b + 32768U) >> 16U);
}
/// The same for colour; 128 is none. Half a step is rounded down, so that 255.5 is 255, as libjpeg does.
constexpr std::uint8_t cb_from_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) noexcept {
  return static_cast<std::uint8_t>((32768U * b + (128U << 16U) + 32767U - 11059U * r - 21709U * g) >> 16U);
}
constexpr std::uint8_t cr_from_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) noexcept {
  return static_cast<std::uint8_t>((32768U * r + (128U << 16U) + 32767U - 27439U * g - 5329U * b) >> 16U);
}

/// R, G, B whose luma is exactly `y`, for every y, and whose colour is as near as 8 bits permit: the very cb and cr
/// wherever some R, G, B has them with this y, which is so for all colours within R, G, B's range (a quarter of the
/// 2^24 triples); for the others nearly the same hue, as saturated as the range permits.
Rgb rgb_from_ycbcr(std::uint8_t y, std::uint8_t cb, std::uint8_t cr) noexcept;

/// A whole picture: each block of pixels with the colour of its sample. \param rgb  3 bytes a pixel, rows without gaps
/// (contract)
void rgb_from_ycbcr(const ImageView& luma, const ChromaView& chroma, std::span<std::uint8_t> rgb) noexcept;

/// The colour of each pixel of an R, G, B picture. \param rgb  3 bytes a pixel \param cb, cr  a byte a pixel
void chroma_from_rgb(std::span<const std::uint8_t> rgb, std::uint8_t* cb, std::uint8_t* cr) noexcept;

}  // namespace ninedot
