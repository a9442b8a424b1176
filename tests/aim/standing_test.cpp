#include "aim/standing.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

using namespace std::chrono_literals;
constexpr double kDeg = kRadPerDeg, kBand_rad = 0.2 * kDeg;
constexpr AimAxis kAxis{-1, 1, 1, 20};

/// An axis that goes where it is told, every 20 ms.
class Axis {
 public:
  AxisGoal step(double goal_rad, double rate_rad_per_s = 0) {
    now_ += 20ms;
    const AxisGoal goal = unit.step(now_, {goal_rad, rate_rad_per_s}, ramp);
    ramp.advance(goal, kAxis, 0.02);
    return goal;
  }
  void settle(double goal_rad) {
    for (int i = 0; i < 50; ++i) step(goal_rad);
  }
  Standing unit{kBand_rad};
  AxisRamp ramp;

 private:
  MonoTime now_{100s};
};

TEST(Standing, RestsAtItsGoalUntilThatLeavesTheDeadBandAndThenGoesAllTheWay) {
  Axis axis;
  axis.settle(0.1);
  EXPECT_TRUE(axis.unit.rests());
  for (const double off : {0.9, -0.9, 0.5, -0.95}) EXPECT_EQ(axis.step(0.1 + off * kBand_rad).angle_rad, 0.1);
  EXPECT_EQ(axis.ramp.angle_rad(), 0.1);
  EXPECT_GT(axis.step(0.1 + 1.1 * kBand_rad).angle_rad, 0.1);
  axis.settle(0.1 + 1.1 * kBand_rad);
  EXPECT_NEAR(axis.ramp.angle_rad(), 0.1 + 1.1 * kBand_rad, kBand_rad / 4) << "to the middle, not to the band's edge";
}

TEST(Standing, DoesNotRestOnTheWay) {
  Axis axis;
  axis.settle(0);
  for (int i = 1; i <= 100; ++i) axis.step(0.004 * i, 0.2);
  EXPECT_FALSE(axis.unit.rests());
  EXPECT_NEAR(axis.ramp.angle_rad(), 0.4, 1e-3) << "what moves faster than the band in 0.2 s is followed evenly";
}

TEST(Standing, WidensItsBandWithEachSwingUntilHuntingEnds) {
  // A head with a dead band of 1 deg, which stands 0.5 deg to either side of where it should, never at it.
  Axis axis;
  double off = 0.5 * kDeg;
  int swings = 0;
  for (int i = 0; i < 20; ++i) {
    const double before = axis.ramp.angle_rad();
    for (int j = 0; j < 15; ++j) axis.step(before + off);
    if (axis.ramp.angle_rad() == before) continue;
    ++swings;
    off = -off;
  }
  EXPECT_LE(swings, 4);
  EXPECT_GE(axis.unit.band_rad(), 0.5 * kDeg);
  EXPECT_LE(axis.unit.band_rad(), Standing::kWidest_rad);
  EXPECT_TRUE(axis.unit.rests());
}

TEST(Standing, IsAsFineAsEverAtAnotherPlace) {
  Axis axis;
  for (const double goal_deg : {0.6, -0.6, 0.6, -0.6}) axis.settle(goal_deg * kDeg);
  ASSERT_GT(axis.unit.band_rad(), kBand_rad);
  axis.settle(0.3);
  EXPECT_EQ(axis.unit.band_rad(), kBand_rad);
}

TEST(Standing, NoiseWithinTheBandIsNoSwing) {
  Axis axis;
  for (int i = 0; i < 200; ++i) axis.step((i % 2 == 0 ? 0.4 : -0.4) * kBand_rad, 0.2);
  EXPECT_EQ(axis.unit.band_rad(), kBand_rad);
}

}  // namespace
}  // namespace ninedot
