#include "calibrate_head/angle_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"

namespace ninedot {
namespace {

/// \param bend_rad  of a whole wave over the range
std::vector<AxisStop> stops_of(double bend_rad, double noise_rad, std::size_t count) {
  test::Random random(7);
  std::vector<AxisStop> stops;
  for (std::size_t i = 0; i < count; ++i) {
    const double told = -0.5 + static_cast<double>(i) / static_cast<double>(count - 1);
    const int side = i % 2 == 0 ? 1 : -1;
    stops.push_back(
        {told, 1.1 * told + bend_rad * std::sin(2 * M_PI * told) - 0.005 * side + noise_rad * random.normal(), side});
  }
  return stops;
}

TEST(AngleTable, IsLinearBetweenItsKnotsAndOnBeyondThem) {
  const AngleTable table{{-1, 0, 2}, {-3, 0, 2}, 0};
  EXPECT_NEAR(table.at(-0.5), -1.5, 1e-12);
  EXPECT_NEAR(table.at(1), 1, 1e-12);
  EXPECT_NEAR(table.at(-2), -6, 1e-12);
  EXPECT_NEAR(table.at(3), 3, 1e-12);
  EXPECT_EQ(anchor_rad(table.told_rad), 0);
  EXPECT_EQ(anchor_rad(std::vector<double>{0.2, 0.5}), 0.2);
  EXPECT_EQ(anchor_rad(std::vector<double>{-0.5, -0.2}), -0.2);
}

TEST(AngleTable, OfAStraightAxisHasTwoKnots) { EXPECT_EQ(choose_knots(stops_of(0, 0.002, 60)).size(), 2U); }

TEST(AngleTable, OfABentAxisHasMore) {
  EXPECT_GE(choose_knots(stops_of(0.02, 0.002, 60)).size(), 6U);
  EXPECT_LT(choose_knots(stops_of(0.003, 0.002, 12)).size(), 5U) << "a dozen stops do not support more";
}

TEST(AngleTable, DoesNotFollowWhatEachPlaceErrsBy) {
  // Steps of a servo: at one place the same error each time.
  std::vector<AxisStop> stops;
  for (int repeat = 0; repeat < 10; ++repeat)
    for (int place = 0; place < 9; ++place)
      stops.push_back(
          {0.1 * place, 0.1 * place + 0.002 * test::random_normal(5, static_cast<std::uint64_t>(place)), 0});
  EXPECT_EQ(choose_knots(stops).size(), 2U);
}

}  // namespace
}  // namespace ninedot
