#include "image/picture_shift.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "tests/image/noise_picture.h"
#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

constexpr int kWidth_px = 320, kHeight_px = 240, kAround_px = 200;

/// Something to look at, larger than a picture of it: patches of light and dark of all sizes.
class Wall {
 public:
  explicit Wall(unsigned seed) : grey_(kWide_px * kHigh_px) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    for (int patch = 0; patch < 120; ++patch) {
      const double x = any(random) * kWide_px, y = any(random) * kHigh_px, size = 8 + 60 * any(random),
                   lighter = 50 * (any(random) - 0.5);
      for (int v = 0; v < kHigh_px; ++v)
        for (int u = 0; u < kWide_px; ++u)
          if (std::abs(u - x) < size && std::abs(v - y) < 0.7 * size)
            grey_[static_cast<std::size_t>(v * kWide_px + u)] += lighter;
    }
  }
  /// \param x_px, y_px  what is in the middle of it \param smear_px  to the right
  std::vector<std::uint8_t> picture(double x_px, double y_px, int smear_px, unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 2);
    std::vector<std::uint8_t> pixels;
    for (int v = 0; v < kHeight_px; ++v)
      for (int u = 0; u < kWidth_px; ++u) {
        double sum = 0;
        for (int s = 0; s <= smear_px; ++s)
          sum += at(u + kAround_px + x_px + s - 0.5 * smear_px, v + kAround_px + y_px);
        pixels.push_back(static_cast<std::uint8_t>(std::clamp(128 + sum / (smear_px + 1) + noise(random), 0.0, 255.0)));
      }
    return pixels;
  }

 private:
  static constexpr int kWide_px = kWidth_px + 2 * kAround_px, kHigh_px = kHeight_px + 2 * kAround_px;
  double at(double x, double y) const {
    const int u = static_cast<int>(std::floor(x)), v = static_cast<int>(std::floor(y));
    const double right = x - u, down = y - v;
    const auto grey = [&](int i, int j) { return grey_[static_cast<std::size_t>(j * kWide_px + i)]; };
    return (1 - down) * ((1 - right) * grey(u, v) + right * grey(u + 1, v)) +
           down * ((1 - right) * grey(u, v + 1) + right * grey(u + 1, v + 1));
  }
  std::vector<double> grey_;
};

ImageView view_of(const std::vector<std::uint8_t>& pixels) { return {pixels.data(), kWidth_px, kHeight_px, kWidth_px}; }

TEST(PictureShift, IsWhatThePictureHasMovedBy) {
  const Wall wall(11);
  for (const auto& [x_px, y_px] : {std::pair{0.0, 0.0}, {3.4, -1.7}, {-41.0, 6.5}, {90.2, -20.0}, {-12.0, 71.3}}) {
    PictureShift shift(kWidth_px, kHeight_px);
    EXPECT_FALSE(shift.to(view_of(wall.picture(0, 0, 0, 1))));
    const std::vector<std::uint8_t> next = wall.picture(-x_px, -y_px, 0, 2);
    const test::AllocationGuard guard;
    const auto by = shift.to(view_of(next));
    EXPECT_EQ(guard.allocations(), 0U);
    ASSERT_TRUE(by) << x_px;
    EXPECT_NEAR(by->x_px, x_px, 1) << y_px;
    EXPECT_NEAR(by->y_px, y_px, 1) << x_px;
  }
}

TEST(PictureShift, IsFoundInSmearedPicturesAsWell) {
  const Wall wall(12);
  PictureShift shift(kWidth_px, kHeight_px);
  EXPECT_FALSE(shift.to(view_of(wall.picture(0, 0, 14, 1))));
  for (int number = 1; number < 4; ++number) {
    const auto by = shift.to(view_of(wall.picture(-38.0 * number, 2.0 * number, 14, static_cast<unsigned>(number))));
    ASSERT_TRUE(by) << number;
    EXPECT_NEAR(by->x_px, 38, 1.5);
    EXPECT_NEAR(by->y_px, -2, 1.5);
  }
}

TEST(PictureShift, SaysNothingOfWhatHasNothingInCommon) {
  int told = 0;
  for (unsigned seed = 20; seed < 40; ++seed) {
    PictureShift shift(kWidth_px, kHeight_px);
    (void)shift.to(view_of(Wall(seed).picture(0, 0, 0, 1)));
    told += shift.to(view_of(Wall(seed + 100).picture(0, 0, 0, 2))).has_value();
  }
  EXPECT_LE(told, 1);
  PictureShift shift(kWidth_px, kHeight_px);
  const std::vector<std::uint8_t> blank(kWidth_px * kHeight_px, 128);
  (void)shift.to(view_of(blank));
  EXPECT_FALSE(shift.to(view_of(blank)));
  (void)shift.to(view_of(test::noise_picture(kWidth_px, kHeight_px, kWidth_px, 2)));
  EXPECT_FALSE(shift.to(view_of(blank)));
  const Wall wall(13);
  (void)shift.to(view_of(wall.picture(0, 0, 0, 1)));
  shift.forget();
  EXPECT_FALSE(shift.to(view_of(wall.picture(0, 0, 0, 2))));
}

}  // namespace
}  // namespace ninedot
