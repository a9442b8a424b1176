#include "aim/axis_ramp.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"

namespace ninedot {
namespace {

constexpr AimAxis kAxis{-1, 1, 0.8, 6};
constexpr double kStep_s = 0.01;

TEST(AxisRamp, KeepsToSlewAccelerationAndRangeWhateverItsGoalDoes) {
  test::Random random(3);
  AxisRamp ramp(0.2);
  double rate = 0;
  AxisGoal goal;
  for (int i = 0; i < 5000; ++i) {
    const double before = ramp.angle_rad();
    // Held for a while, so that it gets somewhere; also far beyond the ends, and moving.
    if (i % 40 == 0) goal = {random.uniform(-1.5, 1.5), random.uniform(-1, 1)};
    ramp.advance(goal, kAxis, kStep_s);
    EXPECT_LE(std::abs(ramp.rate_rad_per_s()), kAxis.slew_rad_per_s + 1e-12);
    EXPECT_LE(std::abs(ramp.rate_rad_per_s() - rate), kAxis.acceleration_rad_per_s2 * kStep_s + 1e-9);
    EXPECT_LE(std::abs(ramp.angle_rad() - before), kAxis.slew_rad_per_s * kStep_s + 1e-12);
    EXPECT_LE(std::abs(ramp.angle_rad()), 1 + 1e-9);
    rate = ramp.rate_rad_per_s();
  }
}

TEST(AxisRamp, ArrivesExactlyWithoutOvershootInTheTimeThatTheWayTakes) {
  for (const double way : {0.002, 0.05, 0.4, 0.95}) {
    AxisRamp ramp;
    double s = 0;
    for (; s < 3 && !(ramp.angle_rad() == way && ramp.rate_rad_per_s() == 0); s += kStep_s) {
      ramp.advance({way, 0}, kAxis, kStep_s);
      EXPECT_LE(ramp.angle_rad(), way);
    }
    EXPECT_EQ(ramp.angle_rad(), way);
    EXPECT_NEAR(s, ramp_time_s(way, kAxis), 0.03) << way;
  }
}

TEST(AxisRamp, TimesOfTriangleAndTrapezium) {
  // 0.06 rad at 6 rad/s^2: 0.1 s up and 0.1 s down, peak 0.6 rad/s. 0.8 rad: 1 s, and 0.8/6 s for the ramps.
  EXPECT_NEAR(ramp_time_s(-0.06, kAxis), 0.2, 1e-12);
  EXPECT_NEAR(ramp_time_s(0.8, kAxis), 1 + 0.8 / 6, 1e-12);
  EXPECT_EQ(ramp_time_s(0, kAxis), 0);
}

TEST(AxisRamp, GoesAlongWithAGoalThatMovesWithoutLaggingBehind) {
  AxisRamp ramp;
  for (int i = 1; i <= 100; ++i) {
    const double goal = 0.1 + 0.5 * kStep_s * i;
    ramp.advance({goal, 0.5}, kAxis, kStep_s);
    if (i > 60) {
      EXPECT_NEAR(ramp.angle_rad(), goal, 1e-6);
    }
  }
}

TEST(AxisRamp, GoesBackFromBeyondItsRange) {
  AxisRamp ramp(1.3);
  for (int i = 0; i < 200; ++i) ramp.advance({1.3, 0}, kAxis, kStep_s);
  EXPECT_EQ(ramp.angle_rad(), 1.0);
}

}  // namespace
}  // namespace ninedot
