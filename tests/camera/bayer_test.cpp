#include "drivers/camera/bayer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "drivers/camera/pixel_format.h"

namespace ninedot {
namespace {

/// What a sensor measured, and how its camera writes it down.
struct Mosaic {
  BayerLayout layout;
  int width = 0, height = 0;
  std::vector<unsigned> samples;  ///< row by row

  unsigned at(int x, int y) const {
    const auto mirrored = [](int i, int count) { return i < 0 ? -i : i >= count ? 2 * count - 2 - i : i; };
    return samples[static_cast<std::size_t>(mirrored(y, height) * width + mirrored(x, width))];
  }
  /// 0 red, 1 green, 2 blue
  std::size_t colour_at(int x, int y) const {
    const bool red_row = (y & 1) == layout.red_y, red_column = (x & 1) == layout.red_x;
    return red_row != red_column ? 1 : red_row ? 0 : 2;
  }
  /// As the formats' definitions say, by MIPI CSI-2 and V4L2. \param gap  bytes between rows
  std::vector<std::uint8_t> written(std::size_t gap) const {
    std::vector<std::uint8_t> bytes;
    const auto put = [&](unsigned value) { bytes.push_back(static_cast<std::uint8_t>(value & 0xFFU)); };
    for (int y = 0; y < height; ++y) {
      if (layout.packing == BayerLayout::Packing::kBytes)
        for (int x = 0; x < width; ++x) put(at(x, y));
      if (layout.packing == BayerLayout::Packing::kWords)
        for (int x = 0; x < width; ++x) put(at(x, y)), put(at(x, y) >> 8U);
      if (layout.packing == BayerLayout::Packing::kPacked) {
        const int group = layout.bits == 10 ? 4 : 2;
        const unsigned lower = layout.bits - 8;
        for (int x = 0; x < width; x += group) {
          unsigned rest = 0;
          for (int i = 0; i < group; ++i) {
            const unsigned sample = x + i < width ? at(x + i, y) : 0;
            put(sample >> lower);
            rest |= (sample & ((1U << lower) - 1)) << (lower * static_cast<unsigned>(i));
          }
          put(rest);
        }
      }
      bytes.insert(bytes.end(), gap, 0xA5);
    }
    return bytes;
  }
};

Mosaic random_mosaic(const PixelFormat& format, int width, int height, std::mt19937& random) {
  Mosaic mosaic{format.bayer, width, height, {}};
  for (int i = 0; i < width * height; ++i)
    mosaic.samples.push_back(static_cast<unsigned>(random() & ((1U << format.bayer.bits) - 1)));
  return mosaic;
}

/// A surface of one colour, each from 0 to 1.
Mosaic plain_mosaic(const PixelFormat& format, int size, const std::array<double, 3>& colour, double black = 0) {
  Mosaic mosaic{format.bayer, size, size, std::vector<unsigned>(static_cast<std::size_t>(size * size))};
  const double largest = (1U << format.bayer.bits) - 1;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      mosaic.samples[static_cast<std::size_t>(y * size + x)] =
          static_cast<unsigned>(std::lround(black + colour[mosaic.colour_at(x, y)] * (largest - black)));
  return mosaic;
}

struct Developed {
  std::vector<std::uint8_t> picture;
  ChromaView chroma;
};

Developed develop(const Mosaic& mosaic, const BayerBalance& balance = {}, std::size_t gap = 0) {
  BayerDeveloper developer(mosaic.layout, balance, mosaic.width, mosaic.height);
  const std::vector<std::uint8_t> bytes = mosaic.written(gap);
  Developed developed{std::vector<std::uint8_t>(developer.picture_bytes() + 1, 0x5A), {}};
  const std::size_t stride = bayer_row_bytes(mosaic.layout, static_cast<std::size_t>(mosaic.width)) + gap;
  EXPECT_EQ(stride * static_cast<std::size_t>(mosaic.height), bytes.size());
  developer.develop(bytes.data(), stride, developed.picture.data());
  EXPECT_EQ(developed.picture.back(), 0x5A) << "writes beyond its end";
  developed.chroma = developer.chroma_of(developed.picture.data());
  return developed;
}

template <typename Use>
void for_bayer_formats(Use use) {
  int count = 0;
  for (const PixelFormat& format : pixel_formats())
    if (format.layout == PixelLayout::kBayer) use(format), ++count;
  EXPECT_EQ(count, 20) << "four orders of 8, 10, 12 bits, the last two also packed";
}

TEST(Bayer, EveryFormatEqualsTheDefinitionAtEverySizeAndStride) {
  std::mt19937 random(5);
  const BayerBalance balance{20, 1.7, 1.3};
  for_bayer_formats([&](const PixelFormat& format) {
    for (int width = 2; width <= 11; ++width)
      for (int height = 2; height <= 5; ++height) {
        const Mosaic mosaic = random_mosaic(format, width, height, random);
        const double largest = (1U << format.bayer.bits) - 1, gains[] = {1.7, 1, 1.3};
        const auto light = [&](int x, int y) {
          return std::clamp(gains[mosaic.colour_at(x, y)] * (mosaic.at(x, y) - 20.0) / (largest - 20), 0.0, 1.0);
        };
        const Developed developed = develop(mosaic, balance, width % 3 == 0 ? 7 : 0);
        for (int y = 0; y < height; ++y)
          for (int x = 0; x < width; ++x) {
            double sum = 0;
            for (int dy = -1; dy <= 1; ++dy)
              for (int dx = -1; dx <= 1; ++dx)
                sum += (dx == 0 ? 2 : 1) * (dy == 0 ? 2 : 1) * light(x + dx, y + dy) / 16;
            const std::uint8_t luma = developed.picture[static_cast<std::size_t>(y * width + x)];
            // Thirteen bits of light are half a step of luma in the dark.
            ASSERT_NEAR(luma, 255 * std::sqrt(sum), sum < 0.01 ? 1.6 : 0.6)
                << format.name << ' ' << width << 'x' << height << " at " << x << ',' << y;
          }
        ASSERT_EQ(developed.chroma.width, (width + 1) / 2);
        ASSERT_EQ(developed.chroma.height, (height + 1) / 2);
        constexpr double kColour = 2;  // likewise of three colours
        for (int y = 0; y < height; y += 2)
          for (int x = 0; x < width; x += 2) {
            double colour[3] = {0, 0, 0};
            for (int dy = 0; dy <= 1; ++dy)
              for (int dx = 0; dx <= 1; ++dx) {
                const std::size_t c = mosaic.colour_at(x + dx, y + dy);
                colour[c] += light(x + dx, y + dy) / (c == 1 ? 2 : 1);
              }
            for (double& c : colour) c = 255 * std::sqrt(c);
            const double grey = 0.299 * colour[0] + 0.587 * colour[1] + 0.114 * colour[2];
            ASSERT_NEAR(developed.chroma.cb_at(x / 2, y / 2), 128 + 0.564 * (colour[2] - grey), kColour) << format.name;
            ASSERT_NEAR(developed.chroma.cr_at(x / 2, y / 2), 128 + 0.713 * (colour[0] - grey), kColour) << format.name;
          }
      }
  });
}

TEST(Bayer, APlainColouredSurfaceHasOneLumaAndOneColourUpToTheBorders) {
  for_bayer_formats([](const PixelFormat& format) {
    const Developed developed = develop(plain_mosaic(format, 6, {0.6, 0.3, 0.1}));
    for (int i = 0; i < 36; ++i) ASSERT_EQ(developed.picture[static_cast<std::size_t>(i)], developed.picture[0]);
    EXPECT_NEAR(developed.picture[0], 255 * std::sqrt(0.25 * 0.6 + 0.5 * 0.3 + 0.25 * 0.1), 1.5) << format.name;
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 3; ++x) {
        EXPECT_EQ(developed.chroma.cb_at(x, y), developed.chroma.cb_at(0, 0)) << format.name;
        EXPECT_EQ(developed.chroma.cr_at(x, y), developed.chroma.cr_at(0, 0)) << format.name;
      }
    EXPECT_GT(developed.chroma.cr_at(0, 0), 150) << "red";
    EXPECT_LT(developed.chroma.cb_at(0, 0), 110) << "not blue";
  });
}

TEST(Bayer, BlackLevelAndGainsMakePaperWhiteAndInkBlack) {
  for_bayer_formats([](const PixelFormat& format) {
    const double black = 16U << (format.bayer.bits - 8);
    // Paper under a warm lamp, as a sensor sees it that is most sensitive to green.
    const BayerBalance balance{black, 0.8 / 0.5, 0.8 / 0.25};
    const Developed paper = develop(plain_mosaic(format, 4, {0.5, 0.8, 0.25}, black), balance);
    EXPECT_NEAR(paper.picture[0], 255 * std::sqrt(0.8), 2) << format.name;
    EXPECT_NEAR(paper.chroma.cb_at(0, 0), 128, 1) << format.name;
    EXPECT_NEAR(paper.chroma.cr_at(0, 0), 128, 1) << format.name;
    EXPECT_EQ(develop(plain_mosaic(format, 4, {0, 0, 0}, black), balance).picture[0], 0) << format.name;
    const Developed clipped = develop(plain_mosaic(format, 4, {1, 1, 1}, black), {black, 2, 2});
    EXPECT_EQ(clipped.picture[0], 255);
    EXPECT_EQ(clipped.chroma.cr_at(0, 0), 128) << format.name << ": too bright is white, not pink";
  });
}

/// Neutral ink and paper look as to a sensor without a mosaic: an edge lies where it is, in every order.
TEST(Bayer, AnEdgeOfGreyIsTheSameInEveryOrder) {
  std::vector<std::uint8_t> first;
  for (const char* const name : {"RGGB10", "BGGR10", "GRBG10", "GBRG10"}) {
    Mosaic mosaic{find_pixel_format(name)->bayer, 12, 12, {}};
    for (int y = 0; y < 12; ++y)
      for (int x = 0; x < 12; ++x) mosaic.samples.push_back(x + 0.3 * y < 7.4 ? 100U : 900U);
    std::vector<std::uint8_t> luma = develop(mosaic).picture;
    luma.resize(144);
    if (first.empty()) first = luma;
    EXPECT_EQ(luma, first) << name;
  }
}

}  // namespace
}  // namespace ninedot
