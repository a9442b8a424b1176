#include "image/dark_spots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace ninedot {
namespace {

constexpr int kWidth_px = 90, kHeight_px = 70;
constexpr int kContrast_lsb = 12;

struct Canvas {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kWidth_px * kHeight_px, 200);
  std::uint8_t& at(int x, int y) { return pixels[static_cast<std::size_t>(y * kWidth_px + x)]; }
  ImageView view() const { return {pixels.data(), kWidth_px, kHeight_px, kWidth_px}; }
  void fill(int x0, int y0, int x1, int y1, int grey) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) at(x, y) = static_cast<std::uint8_t>(grey);
  }
  int threshold_at(int x, int y) const {
    SpotThreshold spots(kWidth_px, kHeight_px);
    return spots.compute(view(), kContrast_lsb).row(y)[x];
  }
};

TEST(SpotThreshold, IsHalfwayBetweenPaperAndInkInASpotNarrowerThanTheSquare) {
  Canvas canvas;
  canvas.fill(40, 30, 48, 38, 40);
  EXPECT_EQ(canvas.threshold_at(44, 34), 120);
}

TEST(SpotThreshold, IgnoresDarkAreasWiderThanTheSquareAndBlankPaper) {
  Canvas canvas;
  canvas.fill(20, 10, 60, 60, 40);
  EXPECT_EQ(canvas.threshold_at(40, 35), 0);
  EXPECT_EQ(Canvas{}.threshold_at(40, 35), 0);
}

TEST(SpotThreshold, FollowsTheEdgeOfAHardShadow) {
  Canvas canvas;
  canvas.fill(45, 0, kWidth_px, kHeight_px, 80);  // paper in shadow, right of x = 45
  canvas.fill(47, 30, 53, 36, 20);                // a spot close to the shadow's edge
  EXPECT_EQ(canvas.threshold_at(50, 33), 50) << "the spot's paper is the shadow's, not the sunlit one two pixels away";
}

TEST(SpotThreshold, SeesInkThroughAVeilThatLeavesNothingDark) {
  Canvas canvas;
  canvas.fill(0, 0, kWidth_px, kHeight_px, 205);  // the wall, and on it
  canvas.fill(20, 10, 70, 60, 225);               // the sheet
  canvas.fill(40, 30, 48, 38, 204);
  EXPECT_EQ(canvas.threshold_at(44, 34), 215);
  canvas.fill(80, 0, kWidth_px, kHeight_px, 20);  // no veil, then, and this is no ink
  EXPECT_EQ(canvas.threshold_at(44, 34), 0);
}

class SpotThresholdOf : public testing::TestWithParam<int> {};

TEST_P(SpotThresholdOf, IsThePlainDefinitionOfClosingAndErosion) {
  const int darkest = GetParam();
  Canvas canvas;
  unsigned state = 1;
  for (auto& pixel : canvas.pixels) {
    state = state * 1664525U + 1013904223U;
    pixel = static_cast<std::uint8_t>(darkest + (256 - darkest) * static_cast<int>(state >> 24) / 256);
  }
  canvas.at(0, 0) = static_cast<std::uint8_t>(darkest);
  const auto extreme = [](const std::vector<std::uint8_t>& in, int before, int after, bool largest) {
    std::vector<std::uint8_t> out(in.size());
    for (int y = 0; y < kHeight_px; ++y)
      for (int x = 0; x < kWidth_px; ++x) {
        int best = largest ? 0 : 255;
        for (int v = std::max(0, y - before); v <= std::min(kHeight_px - 1, y + after); ++v)
          for (int u = std::max(0, x - before); u <= std::min(kWidth_px - 1, x + after); ++u) {
            const int grey = in[static_cast<std::size_t>(v * kWidth_px + u)];
            best = largest ? std::max(best, grey) : std::min(best, grey);
          }
        out[static_cast<std::size_t>(y * kWidth_px + x)] = static_cast<std::uint8_t>(best);
      }
    return out;
  };
  constexpr int kBefore = SpotThreshold::kSquare_px / 2;
  constexpr int kAfter = SpotThreshold::kSquare_px - kBefore - 1;
  const auto closed = extreme(extreme(canvas.pixels, kBefore, kAfter, true), kAfter, kBefore, false);
  const auto eroded = extreme(canvas.pixels, SpotThreshold::kInkReach_px, SpotThreshold::kInkReach_px, false);
  SpotThreshold spots(kWidth_px, kHeight_px);
  const ImageBuffer& threshold = spots.compute(canvas.view(), kContrast_lsb);
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x) {
      const auto i = static_cast<std::size_t>(y * kWidth_px + x);
      const int contrast = closed[i] - eroded[i];
      const int range = closed[i] - darkest;
      const int share =
          std::min(closed[i] / SpotThreshold::kMinContrastShare, range - range / SpotThreshold::kMaxRangeLeft);
      const int needed = std::max(kContrast_lsb, share);
      ASSERT_EQ(threshold.row(y)[x], contrast >= needed ? eroded[i] + (contrast + 1) / 2 : 0) << x << ' ' << y;
    }
}

INSTANTIATE_TEST_SUITE_P(FromDarkestGrey, SpotThresholdOf, testing::Values(0, 130, 200));

}  // namespace
}  // namespace ninedot
