#include "detect/blob_moments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace ninedot {
namespace {

constexpr int kWidth_px = 640, kHeight_px = 480;

struct Picture {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kWidth_px * kHeight_px, 200);
  std::uint8_t& at(int x, int y) { return pixels[static_cast<std::size_t>(y * kWidth_px + x)]; }
  ImageView view() const { return {pixels.data(), kWidth_px, kHeight_px, kWidth_px}; }
};

Region box(int x0, int y0, int width, int height) {
  Region r;
  r.area_px = width * height;
  r.min_x = x0, r.end_x = x0 + width, r.min_y = y0, r.last_y = y0 + height - 1;
  for (int y = y0; y < y0 + height; ++y)
    for (int x = x0; x < x0 + width; ++x)
      r.sum_x += x, r.sum_y += y, r.sum_xx += x * x, r.sum_xy += x * y, r.sum_yy += y * y;
  return r;
}

double narrow_px2(const Moments& m) {
  return 0.5 * (m.xx_px2 + m.yy_px2) - std::hypot(0.5 * (m.xx_px2 - m.yy_px2), m.xy_px2);
}

/// The same from the definition: the centroid first, then the squares of what is left. No lower bound.
bool two_pass(const ImageView& picture, const Region& region, double noise_lsb, Moments& m) {
  const int x0 = std::max(region.min_x - 2, 0), x1 = std::min(region.end_x + 2, picture.width_px);
  const int y0 = std::max(region.min_y - 2, 0), y1 = std::min(region.last_y + 3, picture.height_px);
  double rim = 0, darkest = 255;
  int rim_count = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      darkest = std::min<double>(darkest, picture.at(x, y));
      if (x > x0 && x < x1 - 1 && y > y0 && y < y1 - 1) continue;
      rim += picture.at(x, y), ++rim_count;
    }
  const double paper = rim / rim_count, contrast = paper - darkest;
  if (contrast <= 0) return false;
  const auto weight_at = [&](int x, int y) {
    const double weight = paper - picture.at(x, y);
    const double nearer = picture.at(std::clamp(x, x0 + 1, x1 - 2), std::clamp(y, y0 + 1, y1 - 2));
    const bool counts =
        weight >= std::max(0.12 * contrast, 2 * noise_lsb) && picture.at(x, y) + 4 * noise_lsb >= nearer;
    return counts ? weight : 0;
  };
  m = {};
  double s = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) s += weight_at(x, y);
  if (s <= 0) return false;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) m.x_px += weight_at(x, y) / s * x, m.y_px += weight_at(x, y) / s * y;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const double share = weight_at(x, y) / s, dx = x - m.x_px, dy = y - m.y_px;
      m.xx_px2 += share * dx * dx, m.xy_px2 += share * dx * dy, m.yy_px2 += share * dy * dy;
    }
  m.area_px2 = s / contrast;
  return true;
}

TEST(BlobMoments, OfDarknessAreThoseOfTwoPassesOverAnyBox) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> grey(0, 255), x(1, kWidth_px - 14), y(1, kHeight_px - 14), side(1, 12);
  std::uniform_real_distribution<double> noise(0, 30);
  int compared = 0;
  Picture picture;
  for (int trial = 0; trial < 2000; ++trial) {
    const Region region = box(x(random), y(random), side(random), side(random));
    for (int v = region.min_y - 1; v <= region.last_y + 1; ++v)
      for (int u = region.min_x - 1; u <= region.end_x; ++u) picture.at(u, v) = static_cast<std::uint8_t>(grey(random));
    const double noise_lsb = noise(random);
    Moments found, expected;
    const bool any = measure_darkness(picture.view(), region, noise_lsb, found);
    ASSERT_EQ(any, two_pass(picture.view(), region, noise_lsb, expected));
    if (!any) continue;
    // Sums of single precision over a box of up to 16 px a side.
    EXPECT_NEAR(found.x_px, expected.x_px, 1e-5);
    EXPECT_NEAR(found.y_px, expected.y_px, 1e-5);
    EXPECT_NEAR(found.area_px2, expected.area_px2, 1e-4);
    ASSERT_GE(narrow_px2(found), kPixelVariance_px2 - 1e-12);
    if (narrow_px2(expected) < kPixelVariance_px2) continue;
    ++compared;
    EXPECT_NEAR(found.xx_px2, expected.xx_px2, 1e-4);
    EXPECT_NEAR(found.xy_px2, expected.xy_px2, 1e-4);
    EXPECT_NEAR(found.yy_px2, expected.yy_px2, 1e-4);
  }
  EXPECT_GT(compared, 500);
}

TEST(BlobMoments, OfOnePixelAreThePixels) {
  Picture picture;
  for (const auto& [x, y] : {std::pair(613, 407), std::pair(611, 463), std::pair(5, 7), std::pair(637, 477)}) {
    picture.at(x, y) = 17;
    Moments m;
    ASSERT_TRUE(measure_darkness(picture.view(), box(x, y, 1, 1), 1, m));
    EXPECT_NEAR(m.x_px, x, 1e-12);
    EXPECT_NEAR(m.y_px, y, 1e-12);
    EXPECT_NEAR(m.xx_px2, 1.0 / 12, 1e-12);
    EXPECT_NEAR(m.xy_px2, 0, 1e-12);
    EXPECT_NEAR(m.yy_px2, 1.0 / 12, 1e-12);
  }
}

TEST(BlobMoments, AcrossARowOfPixelsAreThePixelsAndAlongItUnchanged) {
  for (const bool diagonal : {false, true}) {
    Picture picture;
    for (int i = 0; i < 6; ++i) picture.at(300 + i, diagonal ? 200 + i : 200) = 17;
    Moments m;
    ASSERT_TRUE(measure_darkness(picture.view(), box(300, 200, 6, diagonal ? 6 : 1), 1, m));
    const double along = 35.0 / 12 * (diagonal ? 2 : 1);  // (n^2 - 1) / 12 steps
    EXPECT_NEAR(narrow_px2(m), 1.0 / 12, 1e-12);
    EXPECT_NEAR(m.xx_px2 + m.yy_px2 - narrow_px2(m), along, 1e-9);
  }
}

TEST(BlobMoments, OfAnOutlineDoNotDependOnWhereItIs) {
  const Moments near = outline_moments(box(3, 4, 7, 5)), far = outline_moments(box(30003, 20004, 7, 5));
  EXPECT_EQ(near.xx_px2, far.xx_px2);
  EXPECT_EQ(near.xy_px2, far.xy_px2);
  EXPECT_EQ(near.yy_px2, far.yy_px2);
  EXPECT_DOUBLE_EQ(near.xx_px2, 7.0 * 7.0 / 12);
  EXPECT_DOUBLE_EQ(far.y_px, 20006);
}

}  // namespace
}  // namespace ninedot
