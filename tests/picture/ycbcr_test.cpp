#include "drivers/picture/ycbcr.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

namespace ninedot {
namespace {

std::size_t place_of(int y, int cb, int cr) { return static_cast<std::size_t>((y << 16) | (cb << 8) | cr); }

std::uint8_t level(int value) { return static_cast<std::uint8_t>(value); }

TEST(Ycbcr, LumaIsTheRoundedWeightedSumOfBt601) {
  for (int r = 0; r < 256; r += 15)
    for (int g = 0; g < 256; g += 15)
      for (int b = 0; b < 256; b += 15)
        ASSERT_NEAR(luma_from_rgb(level(r), level(g), level(b)), 0.299 * r + 0.587 * g + 0.114 * b, 0.51);
  EXPECT_EQ(luma_from_rgb(255, 255, 255), 255);
}

TEST(Ycbcr, ColourIsTheRoundedDifferenceOfBt601) {
  for (int r = 0; r < 256; r += 15)
    for (int g = 0; g < 256; g += 15)
      for (int b = 0; b < 256; b += 15) {
        const double cb = 128 - 0.168736 * r - 0.331264 * g + 0.5 * b;
        const double cr = 128 + 0.5 * r - 0.418688 * g - 0.081312 * b;
        ASSERT_NEAR(cb_from_rgb(level(r), level(g), level(b)), cb, 0.51);
        ASSERT_NEAR(cr_from_rgb(level(r), level(g), level(b)), cr, 0.51);
      }
  for (int grey = 0; grey < 256; ++grey) {
    EXPECT_EQ(cb_from_rgb(level(grey), level(grey), level(grey)), 128);
    EXPECT_EQ(cr_from_rgb(level(grey), level(grey), level(grey)), 128);
  }
}

TEST(Ycbcr, TheWayToRgbAndBackKeepsEveryLumaAndEveryColourThatRgbHas) {
  std::vector<bool> is_in_rgb(std::size_t{1} << 24U);
  for (int r = 0; r < 256; ++r)
    for (int g = 0; g < 256; ++g)
      for (int b = 0; b < 256; ++b)
        is_in_rgb[place_of(luma_from_rgb(level(r), level(g), level(b)), cb_from_rgb(level(r), level(g), level(b)),
                           cr_from_rgb(level(r), level(g), level(b)))] = true;
  int in_rgb = 0, wrong_luma = 0, wrong_colour = 0, other_side = 0;
  for (int y = 0; y < 256; ++y)
    for (int cb = 0; cb < 256; ++cb)
      for (int cr = 0; cr < 256; ++cr) {
        const Rgb rgb = rgb_from_ycbcr(level(y), level(cb), level(cr));
        const int cb_back = cb_from_rgb(rgb.r, rgb.g, rgb.b), cr_back = cr_from_rgb(rgb.r, rgb.g, rgb.b);
        if (luma_from_rgb(rgb.r, rgb.g, rgb.b) != y) ++wrong_luma;
        if (is_in_rgb[place_of(y, cb, cr)]) {
          ++in_rgb;
          if (cb_back != cb || cr_back != cr) ++wrong_colour;
        } else if ((cb_back - 128) * (cb - 128) < -128 || (cr_back - 128) * (cr - 128) < -128) {
          ++other_side;
        }
      }
  EXPECT_EQ(wrong_luma, 0);
  EXPECT_EQ(wrong_colour, 0);
  EXPECT_EQ(other_side, 0) << "a colour out of range became another colour";
  EXPECT_GT(in_rgb, 3'900'000);
}

TEST(Ycbcr, APictureTakesTheSampleOfEachBlock) {
  constexpr int kWidth = 5, kHeight = 3;  // the last column and row have less than a block
  const std::vector<std::uint8_t> luma(kWidth * kHeight, 120);
  const std::vector<std::uint8_t> cb{100, 110, 120, 130, 140, 150}, cr(6, 135);
  std::vector<std::uint8_t> rgb(3 * luma.size());
  rgb_from_ycbcr(ImageView{luma.data(), kWidth, kHeight, kWidth}, ChromaView{cb.data(), cr.data(), 3, 2, 1, 3}, rgb);
  std::vector<std::uint8_t> cb_back(luma.size()), cr_back(luma.size());
  chroma_from_rgb(rgb, cb_back.data(), cr_back.data());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(cb_back[static_cast<std::size_t>(y * kWidth + x)], cb[static_cast<std::size_t>(y / 2 * 3 + x / 2)]);
      EXPECT_EQ(cr_back[static_cast<std::size_t>(y * kWidth + x)], 135);
    }
}

}  // namespace
}  // namespace ninedot
