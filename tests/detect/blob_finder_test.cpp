#include "detect/blob_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "tests/detect/sharpened_spots.h"

namespace ninedot {
namespace {

/// One dark ellipse, blurred by 0.6 px, on a slope of light, with noise.
std::vector<std::uint8_t> one_ellipse(double x_px, double y_px, double a_px, double b_px, double angle_rad,
                                      double noise_lsb) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, noise_lsb);
  std::vector<std::uint8_t> pixels(640 * 480);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      double cover = 0;
      if (std::hypot(x - x_px, y - y_px) < a_px + 3) {
        for (int sub = 0; sub < 64; ++sub) {
          const double dx = x + (sub % 8 + 0.5) / 8 - 0.5 - x_px, dy = y + (sub / 8 + 0.5) / 8 - 0.5 - y_px;
          const double u = (dx * std::cos(angle_rad) + dy * std::sin(angle_rad)) / a_px;
          const double v = (-dx * std::sin(angle_rad) + dy * std::cos(angle_rad)) / b_px;
          cover += (u * u + v * v < 1) / 64.0;
        }
      }
      const double paper = 150 + 0.12 * x;
      pixels[static_cast<std::size_t>(y * 640 + x)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(paper * (1 - 0.75 * cover) + noise(random)), 0L, 255L));
    }
  return pixels;
}

const Blob* nearest(const BlobList& blobs, double x_px, double y_px) {
  const auto distance = [&](const Blob& b) { return std::hypot(b.x_px - x_px, b.y_px - y_px); };
  const Blob* best = std::min_element(blobs.begin(), blobs.end(),
                                      [&](const Blob& a, const Blob& b) { return distance(a) < distance(b); });
  return best != blobs.end() && distance(*best) < 2 ? best : nullptr;
}

class DotSizes : public testing::TestWithParam<double> {};

TEST_P(DotSizes, AreFoundWithTheirCentreAreaAndAxes) {
  const double diameter_px = GetParam();
  const double a_px = diameter_px / 2, b_px = a_px * 0.8;
  const auto pixels = one_ellipse(320.3, 200.7, a_px, b_px, 0.5, 1.5);
  BlobFinder finder(640, 480);
  WorkBudget budget;
  BlobList blobs;
  finder.find_blobs({pixels.data(), 640, 480, 640}, {}, blobs, budget);
  const Blob* blob = nearest(blobs, 320.3, 200.7);
  ASSERT_NE(blob, nullptr) << diameter_px;
  EXPECT_NEAR(blob->x_px, 320.3, 0.12 + 0.004 * diameter_px);
  EXPECT_NEAR(blob->y_px, 200.7, 0.12 + 0.004 * diameter_px);
  EXPECT_NEAR(blob->area_px2 / (M_PI * a_px * b_px), 1, 0.06 + 1.2 / diameter_px);
  EXPECT_NEAR(blob->semi_major_px(), a_px, 0.5 + 0.03 * a_px);
}

// 2.4 px: a ring dot at 7.6 m; 130 px: P9 at 0.28 m.
INSTANTIATE_TEST_SUITE_P(BlobFinder, DotSizes, testing::Values(2.6, 4.0, 8.0, 16.0, 24.0, 40.0, 70.0, 100.0, 130.0));

TEST(BlobFinder, FindsTheSameBlobInAPartOfThePictureAsInTheWhole) {
  const auto pixels = one_ellipse(320.3, 200.7, 6, 5, 0.5, 1.5);
  BlobFinder finder(640, 480);
  WorkBudget budget;
  BlobList whole, part;
  finder.find_blobs({pixels.data(), 640, 480, 640}, {}, whole, budget);
  const std::uint8_t* corner = pixels.data() + 140 * 640 + 260;
  finder.find_blobs({corner, 120, 120, 640}, {}, part, budget);
  const Blob* a = nearest(whole, 320.3, 200.7);
  const Blob* b = nearest(part, 60.3, 60.7);
  ASSERT_TRUE(a != nullptr && b != nullptr);
  EXPECT_NEAR(a->x_px, b->x_px + 260, 0.02);
  EXPECT_NEAR(a->y_px, b->y_px + 140, 0.02);
}

TEST(BlobFinder, LetsNoBlobBeNarrowerThanAPixel) {
  BlobFinder finder(640, 480);
  WorkBudget budget;
  BlobList blobs;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto pixels = test::sharpened_spots(seed);
    budget = {};
    finder.find_blobs({pixels.data(), 640, 480, 640}, {}, blobs, budget);
    for (const Blob& b : blobs) {
      const double pixel_px2 = 1.0 / 12 * (1 << (2 * b.level));
      const double narrow_px2 = 0.5 * (b.xx_px2 + b.yy_px2) - std::hypot(0.5 * (b.xx_px2 - b.yy_px2), b.xy_px2);
      ASSERT_GE(narrow_px2, pixel_px2 * (1 - 1e-4)) << seed << ": " << b.xx_px2 << ' ' << b.xy_px2 << ' ' << b.yy_px2;
      ASSERT_TRUE(std::isfinite(b.semi_major_px()));
    }
  }
}

/// Dots of 4 px in rows and columns, on white.
std::vector<std::uint8_t> dot_grid(int pitch_px) {
  std::vector<std::uint8_t> pixels(640 * 480, 220);
  for (int y = 4; y + 8 < 480; y += pitch_px)
    for (int x = 4; x + 8 < 640; x += pitch_px)
      for (int v = 0; v < 4; ++v)
        for (int u = 0; u < 4; ++u)
          if ((u % 3 != 0) || (v % 3 != 0)) pixels[static_cast<std::size_t>((y + v) * 640 + x + u)] = 30;
  return pixels;
}

TEST(BlobFinder, CountsTheBlobsThatItHasNoRoomFor) {
  BlobFinder finder(640, 480);
  WorkBudget budget;
  BlobList blobs;
  const auto few = dot_grid(40), many = dot_grid(11);  // 192 dots, 2494 dots
  finder.find_blobs({few.data(), 640, 480, 640}, {0, 0}, blobs, budget);
  EXPECT_EQ(blobs.size(), 192U);
  EXPECT_EQ(finder.blobs_cut(), 0U);
  finder.find_blobs({many.data(), 640, 480, 640}, {0, 0}, blobs, budget);
  EXPECT_TRUE(blobs.full());
  EXPECT_EQ(finder.blobs_cut(), 2494U - kMaxBlobs);
}

TEST(BlobFinder, MeasuresByAndByWhatTheBudgetDoesNotAllowAtOnce) {
  BlobFinder finder(640, 480);
  const auto many = dot_grid(20);
  std::set<std::pair<int, int>> seen;
  for (int picture = 0; picture < 4; ++picture) {
    BlobList blobs;
    WorkBudget budget{.regions = 200};
    finder.find_blobs({many.data(), 640, 480, 640}, {0, 0}, blobs, budget);
    EXPECT_EQ(blobs.size(), 200U);
    EXPECT_EQ(budget.regions, 0);
    EXPECT_TRUE(budget.is_overdrawn);
    for (const Blob& blob : blobs) seen.emplace(std::lround(blob.x_px), std::lround(blob.y_px));
  }
  EXPECT_EQ(seen.size(), 32U * 24U);
}

/// Thin vertical lines that no blob is made of, and a dot below them.
TEST(BlobFinder, LooksByAndByAtRowsThatHadNoRoom) {
  std::vector<std::uint8_t> pixels(640 * 480, 220);
  // Blank rows where the noise is estimated: a picture that claims to have none.
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; x += 3)
      if (y % 8 != 4) pixels[static_cast<std::size_t>(y * 640 + x)] = 30;
  for (int y = 440; y < 470; ++y)
    for (int x = 300; x < 330; ++x)
      pixels[static_cast<std::size_t>(y * 640 + x)] = std::hypot(x - 315, y - 455) < 4 ? 30 : 220;
  BlobFinder finder(640, 480);
  BlobList blobs;
  WorkBudget budget;
  finder.find_blobs({pixels.data(), 640, 480, 640}, {0, 0}, blobs, budget);
  EXPECT_EQ(nearest(blobs, 315, 455), nullptr) << "or this picture tests nothing";
  EXPECT_TRUE(budget.is_overdrawn);
  bool seen = false;
  for (int picture = 0; picture < 6; ++picture) {
    budget = {};
    finder.find_blobs({pixels.data(), 640, 480, 640}, {0, 0}, blobs, budget);
    seen = seen || nearest(blobs, 315, 455) != nullptr;
  }
  EXPECT_TRUE(seen);
}

TEST(BlobFinder, SeesTheSmallDotsOfANoisyPicture) {
  constexpr int kSpacing_px = 40, kDots = 15 * 11;
  for (const double diameter_px : {4.0, 6.0}) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 18);
    std::vector<std::uint8_t> pixels(640 * 480);
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; ++x) {
        const double off_px = std::hypot((x + kSpacing_px / 2) % kSpacing_px - kSpacing_px / 2,
                                         (y + kSpacing_px / 2) % kSpacing_px - kSpacing_px / 2);
        const double cover = 1 / (1 + std::exp((off_px - diameter_px / 2) / 0.35));
        pixels[static_cast<std::size_t>(y * 640 + x)] =
            static_cast<std::uint8_t>(std::clamp(std::lround(120 - 90 * cover + noise(random)), 0L, 255L));
      }
    BlobFinder finder(640, 480);
    WorkBudget budget;
    BlobList blobs;
    finder.find_blobs({pixels.data(), 640, 480, 640}, {}, blobs, budget);
    int seen = 0;
    for (int y = kSpacing_px; y < 480; y += kSpacing_px)
      for (int x = kSpacing_px; x < 640; x += kSpacing_px) seen += nearest(blobs, x, y) != nullptr;
    EXPECT_GT(seen, 0.9 * kDots) << diameter_px;
    EXPECT_TRUE(finder.is_smoothed());
    EXPECT_NEAR(finder.noise_at_lsb(0), 18 * 0.375, 1);
    EXPECT_NEAR(finder.noise_at_lsb(1), 18 * 0.5, 1);
  }
}

class Noises : public testing::TestWithParam<double> {};

TEST_P(Noises, AreTakenForNothing) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(120, GetParam());
  std::vector<std::uint8_t> pixels(640 * 480);
  for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(std::clamp(noise(random), 0.0, 255.0));
  BlobFinder finder(640, 480);
  WorkBudget budget;
  BlobList blobs;
  finder.find_blobs({pixels.data(), 640, 480, 640}, {}, blobs, budget);
  EXPECT_LT(blobs.size(), 300U);
  std::fill(pixels.begin(), pixels.end(), std::uint8_t{120});
  finder.find_blobs({pixels.data(), 640, 480, 640}, {}, blobs, budget);
  EXPECT_TRUE(blobs.empty());
}

INSTANTIATE_TEST_SUITE_P(BlobFinder, Noises, testing::Values(2.0, 6.0, 7.9, 8.1, 14.0, 24.0));

}  // namespace
}  // namespace ninedot
