#include "drivers/camera/pixel_format.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr std::uint32_t fourcc(const char (&code)[5]) noexcept {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<std::uint8_t>(code[i])} << (8 * i);
  return value;
}

using Packing = BayerLayout::Packing;

constexpr PixelFormat bayer(std::string_view name, const char (&code)[5], Packing packing, unsigned bits, int red_x,
                            int red_y) noexcept {
  return {name, fourcc(code), PixelLayout::kBayer, 0, {packing, bits, red_x, red_y}};
}

constexpr std::array kFormats{
    PixelFormat{"GREY", fourcc("GREY"), PixelLayout::kLumaPlane},
    PixelFormat{"NV12", fourcc("NV12"), PixelLayout::kLumaPlane},
    PixelFormat{"NV21", fourcc("NV21"), PixelLayout::kLumaPlane},
    PixelFormat{"YU12", fourcc("YU12"), PixelLayout::kLumaPlane},
    PixelFormat{"YUYV", fourcc("YUYV"), PixelLayout::kYuyv},
    PixelFormat{"UYVY", fourcc("UYVY"), PixelLayout::kUyvy},
    PixelFormat{"Y10", fourcc("Y10 "), PixelLayout::kLuma16, 2},
    PixelFormat{"Y12", fourcc("Y12 "), PixelLayout::kLuma16, 4},
    PixelFormat{"Y16", fourcc("Y16 "), PixelLayout::kLuma16, 8},
    PixelFormat{"Y10P", fourcc("Y10P"), PixelLayout::kPacked10},
    PixelFormat{"Y12P", fourcc("Y12P"), PixelLayout::kPacked12},
    bayer("RGGB10P", "pRAA", Packing::kPacked, 10, 0, 0),
    bayer("BGGR10P", "pBAA", Packing::kPacked, 10, 1, 1),
    bayer("GRBG10P", "pgAA", Packing::kPacked, 10, 1, 0),
    bayer("GBRG10P", "pGAA", Packing::kPacked, 10, 0, 1),
    bayer("RGGB10", "RG10", Packing::kWords, 10, 0, 0),
    bayer("BGGR10", "BG10", Packing::kWords, 10, 1, 1),
    bayer("GRBG10", "BA10", Packing::kWords, 10, 1, 0),
    bayer("GBRG10", "GB10", Packing::kWords, 10, 0, 1),
    bayer("RGGB12P", "pRCC", Packing::kPacked, 12, 0, 0),
    bayer("BGGR12P", "pBCC", Packing::kPacked, 12, 1, 1),
    bayer("GRBG12P", "pgCC", Packing::kPacked, 12, 1, 0),
    bayer("GBRG12P", "pGCC", Packing::kPacked, 12, 0, 1),
    bayer("RGGB12", "RG12", Packing::kWords, 12, 0, 0),
    bayer("BGGR12", "BG12", Packing::kWords, 12, 1, 1),
    bayer("GRBG12", "BA12", Packing::kWords, 12, 1, 0),
    bayer("GBRG12", "GB12", Packing::kWords, 12, 0, 1),
    bayer("RGGB", "RGGB", Packing::kBytes, 8, 0, 0),
    bayer("BGGR", "BA81", Packing::kBytes, 8, 1, 1),
    bayer("GRBG", "GRBG", Packing::kBytes, 8, 1, 0),
    bayer("GBRG", "GBRG", Packing::kBytes, 8, 0, 1),
    PixelFormat{"MJPG", fourcc("MJPG"), PixelLayout::kJpeg},
    PixelFormat{"JPEG", fourcc("JPEG"), PixelLayout::kJpeg},
};

void copy_every_second(const std::uint8_t* row, std::size_t first, std::size_t width, std::uint8_t* luma) noexcept {
  for (std::size_t x = 0; x < width; ++x) luma[x] = row[2 * x + first];
}

void take_upper_bits(const std::uint8_t* row, unsigned surplus_bits, std::size_t width, std::uint8_t* luma) noexcept {
  for (std::size_t x = 0; x < width; ++x) {
    const unsigned word = row[2 * x] | unsigned{row[2 * x + 1]} << 8U;
    luma[x] = static_cast<std::uint8_t>(std::min(word >> surplus_bits, 255U));
  }
}

/// MIPI CSI-2: groups of `group` samples' upper bytes, followed by one byte with their lower bits.
void take_upper_bytes(const std::uint8_t* row, std::size_t group, std::size_t width, std::uint8_t* luma) noexcept {
  for (std::size_t x = 0, at = 0; x < width; x += group, at += group + 1)
    std::memcpy(luma + x, row + at, std::min(group, width - x));
}

void convert_row(const PixelFormat& format, const std::uint8_t* row, std::size_t width, std::uint8_t* luma) noexcept {
  switch (format.layout) {
    case PixelLayout::kLumaPlane:
      std::memcpy(luma, row, width);
      return;
    case PixelLayout::kYuyv:
      return copy_every_second(row, 0, width, luma);
    case PixelLayout::kUyvy:
      return copy_every_second(row, 1, width, luma);
    case PixelLayout::kLuma16:
      return take_upper_bits(row, format.surplus_bits, width, luma);
    case PixelLayout::kPacked10:
      return take_upper_bytes(row, 4, width, luma);
    case PixelLayout::kPacked12:
      return take_upper_bytes(row, 2, width, luma);
    case PixelLayout::kBayer:
    case PixelLayout::kJpeg:
      EXPECTS(false && "not a format of single rows");
  }
}

}  // namespace

std::span<const PixelFormat> pixel_formats() noexcept { return kFormats; }

const PixelFormat* find_pixel_format(std::string_view name) noexcept {
  const auto found = std::ranges::find(kFormats, name, &PixelFormat::name);
  return found == kFormats.end() ? nullptr : &*found;
}

const PixelFormat* find_pixel_format(std::uint32_t code) noexcept {
  const auto found = std::ranges::find(kFormats, code, &PixelFormat::fourcc);
  return found == kFormats.end() ? nullptr : &*found;
}

std::size_t row_bytes(const PixelFormat& format, int width_px) noexcept {
  const auto width = static_cast<std::size_t>(width_px);
  switch (format.layout) {
    case PixelLayout::kLumaPlane:
      return width;
    case PixelLayout::kBayer:
      return bayer_row_bytes(format.bayer, width);
    case PixelLayout::kLuma16:
    case PixelLayout::kYuyv:
    case PixelLayout::kUyvy:
      return 2 * width;
    case PixelLayout::kPacked10:
      return width + (width + 3) / 4;
    case PixelLayout::kPacked12:
      return width + (width + 1) / 2;
    case PixelLayout::kJpeg:
      return 0;
  }
  return 0;
}

void convert_to_luma(const PixelFormat& format, const std::uint8_t* pixels, std::size_t stride_bytes, int width_px,
                     int height_px, std::uint8_t* luma) noexcept {
  const auto width = static_cast<std::size_t>(width_px);
  for (int y = 0; y < height_px; ++y)
    convert_row(format, pixels + static_cast<std::size_t>(y) * stride_bytes, width,
                luma + static_cast<std::size_t>(y) * width);
}

ChromaView chroma_of(const PixelFormat& format, const std::uint8_t* pixels, std::size_t stride_bytes, int width_px,
                     int height_px, std::size_t bytes) noexcept {
  const auto stride = static_cast<std::ptrdiff_t>(stride_bytes);
  const int width = (width_px + 1) / 2, half_height = (height_px + 1) / 2;
  const std::size_t luma_bytes = stride_bytes * static_cast<std::size_t>(height_px);
  const std::uint8_t* const behind = pixels + luma_bytes;
  // Two pixels share a colour; one left over at the end of a row has none of its own.
  if (format.layout == PixelLayout::kYuyv) return {pixels + 1, pixels + 3, width_px / 2, height_px, 4, stride};
  if (format.layout == PixelLayout::kUyvy) return {pixels, pixels + 2, width_px / 2, height_px, 4, stride};
  const bool in_pairs = format.name == "NV12" || format.name == "NV21";
  if (!in_pairs && format.name != "YU12") return {};
  // Pairs: rows as long as the luma's. Planes: half as long, all of Cb before Cr.
  const std::size_t plane_bytes = (stride_bytes + 1) / 2 * static_cast<std::size_t>(half_height);
  if (bytes < luma_bytes + 2 * plane_bytes) return {};
  if (format.name == "NV12") return {behind, behind + 1, width, half_height, 2, stride};
  if (format.name == "NV21") return {behind + 1, behind, width, half_height, 2, stride};
  return {behind, behind + plane_bytes, width, half_height, 1, (stride + 1) / 2};
}

}  // namespace ninedot
