#pragma once
/// The pixel formats that cameras deliver and that become 8-bit luma here, and how.
///
/// | format | luma |
/// |---|---|
/// | GREY, NV12, NV21, YU12 | the first plane as it is, in the driver's buffer |
/// | YUYV, UYVY | every second byte |
/// | Y10, Y12, Y16 (16-bit words, little-endian) | the upper eight of the 10, 12 or 16 bits, saturated |
/// | Y10P, Y12P (MIPI packed) | the upper eight bits of each sample |
/// | RGGB, BGGR, GRBG, GBRG: 8-bit Bayer; with 10 or 12 behind it: so many bits in 16; then P: MIPI packed | bayer.h |
/// | MJPG | the Y of the JPEG |
///
/// The colour of NV12, NV21, YU12, YUYV and UYVY stays readable beside the luma: chroma_of. Bayer's is made: bayer.h.
/// A limited range of levels (16..235) is left as it is: the detector needs contrast, not absolute levels.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/camera/bayer.h"
#include "image/chroma_view.h"

namespace ninedot {

enum class PixelLayout { kLumaPlane, kLuma16, kPacked10, kPacked12, kYuyv, kUyvy, kBayer, kJpeg };

struct PixelFormat {
  std::string_view name;     ///< as in the configuration and in V4L2's documentation
  std::uint32_t fourcc = 0;  ///< V4L2's, which are libcamera's (DRM's) only in part
  PixelLayout layout{};
  unsigned surplus_bits = 0;  ///< kLuma16: bits beyond eight
  BayerLayout bayer{};        ///< kBayer
};

/// In order of preference: what costs nothing first, what loses something last.
std::span<const PixelFormat> pixel_formats() noexcept;
/// \return  nullptr: not one of ours
const PixelFormat* find_pixel_format(std::string_view name) noexcept;
const PixelFormat* find_pixel_format(std::uint32_t fourcc) noexcept;

/// Least bytes of one row; 0 for kJpeg.
std::size_t row_bytes(const PixelFormat& format, int width_px) noexcept;

/// \param pixels  height_px rows of at least row_bytes, `stride_bytes` apart
/// \param luma  width_px * height_px bytes, rows without gaps; not overlapping
/// Not for kBayer and kJpeg (contract). Memory: none. Threads: pure.
void convert_to_luma(const PixelFormat& format, const std::uint8_t* pixels, std::size_t stride_bytes, int width_px,
                     int height_px, std::uint8_t* luma) noexcept;

/// The colour beside the luma, in the same memory. Empty where the format has none, and where `bytes` do not hold it.
/// \param pixels  the first plane, the others right behind it \param bytes  readable from there on
/// Memory: none. Threads: pure.
ChromaView chroma_of(const PixelFormat& format, const std::uint8_t* pixels, std::size_t stride_bytes, int width_px,
                     int height_px, std::size_t bytes) noexcept;

}  // namespace ninedot
