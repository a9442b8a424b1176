#include "drivers/camera/pixel_format.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace ninedot {
namespace {

/// One luma sample, straight from the formats' definitions.
unsigned luma_at(const PixelFormat& format, const std::vector<std::uint8_t>& pixels, std::size_t stride, int x, int y) {
  const auto byte = [&](int row, std::size_t column) {
    return unsigned{pixels[static_cast<std::size_t>(row) * stride + column]};
  };
  const auto column = static_cast<std::size_t>(x);
  switch (format.layout) {
    case PixelLayout::kLumaPlane:
      return byte(y, column);
    case PixelLayout::kYuyv:
      return byte(y, 2 * column);
    case PixelLayout::kUyvy:
      return byte(y, 2 * column + 1);
    case PixelLayout::kLuma16:
      return std::min(255U, (byte(y, 2 * column) + 256 * byte(y, 2 * column + 1)) / (1U << format.surplus_bits));
    case PixelLayout::kPacked10:  // the group's fifth byte holds the bits that eight do not need
      return byte(y, column / 4 * 5 + column % 4);
    case PixelLayout::kPacked12:
      return byte(y, column / 2 * 3 + column % 2);
    case PixelLayout::kBayer:
    case PixelLayout::kJpeg:
      break;
  }
  ADD_FAILURE();
  return 0;
}

TEST(PixelFormat, EveryConverterEqualsTheDefinitionAtEverySizeAndStride) {
  std::mt19937 random(20);
  for (const PixelFormat& format : pixel_formats()) {
    if (format.layout == PixelLayout::kJpeg || format.layout == PixelLayout::kBayer) continue;
    for (int width = 2; width <= 21; ++width)
      for (int height = 2; height <= 5; ++height)
        for (const std::size_t gap : {0U, 3U}) {
          const std::size_t stride = row_bytes(format, width) + gap;
          std::vector<std::uint8_t> pixels(stride * static_cast<std::size_t>(height) - gap);
          for (std::uint8_t& byte : pixels) byte = static_cast<std::uint8_t>(random());
          const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
          std::vector<std::uint8_t> luma(count + 1, 0xA5);
          convert_to_luma(format, pixels.data(), stride, width, height, luma.data());
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
              ASSERT_EQ(
                  luma[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)],
                  luma_at(format, pixels, stride, x, y))
                  << format.name << ' ' << width << 'x' << height << " at " << x << ',' << y;
          ASSERT_EQ(luma[count], 0xA5) << format.name << " writes beyond its end";
        }
  }
}

TEST(PixelFormat, AllValuesOfSixteenBitSamplesAreScaledAndSaturated) {
  for (const char* const name : {"Y10", "Y12", "Y16"}) {
    const PixelFormat& format = *find_pixel_format(name);
    for (unsigned value = 0; value <= 0xFFFF; ++value) {
      const std::uint8_t word[2] = {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8U)};
      std::uint8_t luma = 0;
      convert_to_luma(format, word, 2, 1, 1, &luma);
      ASSERT_EQ(luma, std::min(255U, value >> format.surplus_bits)) << name;
    }
  }
}

TEST(PixelFormat, TheColourIsWhereTheFormatsDefinitionPutsIt) {
  constexpr int kWidth = 6, kHeight = 4;
  constexpr std::size_t kStride = 16;
  std::vector<std::uint8_t> pixels(kStride * kHeight * 3 / 2);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i);
  constexpr std::size_t kBehind = kStride * kHeight, kPlane = kStride / 2 * kHeight / 2;
  // Where Cb and Cr of sample (2, 1) are.
  const std::map<std::string, std::pair<std::size_t, std::size_t>> places{
      {"NV12", {kBehind + kStride + 4, kBehind + kStride + 5}},
      {"NV21", {kBehind + kStride + 5, kBehind + kStride + 4}},
      {"YU12", {kBehind + kStride / 2 + 2, kBehind + kPlane + kStride / 2 + 2}},
      {"YUYV", {kStride + 9, kStride + 11}},
      {"UYVY", {kStride + 8, kStride + 10}}};
  for (const PixelFormat& format : pixel_formats()) {
    const ChromaView chroma = chroma_of(format, pixels.data(), kStride, kWidth, kHeight, pixels.size());
    const auto place = places.find(std::string(format.name));
    EXPECT_EQ(chroma.empty(), place == places.end()) << format.name;
    if (place == places.end()) continue;
    EXPECT_EQ(chroma.cb_at(2, 1), pixels[place->second.first]) << format.name;
    EXPECT_EQ(chroma.cr_at(2, 1), pixels[place->second.second]) << format.name;
    EXPECT_EQ(chroma.width, kWidth / 2);
    EXPECT_EQ(chroma.height, format.layout == PixelLayout::kLumaPlane ? kHeight / 2 : kHeight);
  }
  const PixelFormat& nv12 = *find_pixel_format("NV12");
  EXPECT_TRUE(chroma_of(nv12, pixels.data(), kStride, kWidth, kHeight, pixels.size() - 1).empty()) << "too short";
}

TEST(PixelFormat, NamesAndCodesAreUnique) {
  for (const PixelFormat& format : pixel_formats()) {
    EXPECT_EQ(find_pixel_format(format.name), &format);
    EXPECT_EQ(find_pixel_format(format.fourcc), &format);
  }
  EXPECT_EQ(find_pixel_format("H264"), nullptr);
}

}  // namespace
}  // namespace ninedot
