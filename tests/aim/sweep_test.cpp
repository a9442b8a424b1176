#include "aim/sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "aim/axis_ramp.h"
#include "base/units.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

constexpr double kDeg = kRadPerDeg;
constexpr double kHalfWidth_rad = 24 * kDeg, kHalfHeight_rad = 18 * kDeg;

AimOptions options() {
  AimOptions options;
  options.pan = {-60 * kDeg, 60 * kDeg, 90 * kDeg, 1000 * kDeg};
  options.tilt = {-40 * kDeg, 30 * kDeg, 60 * kDeg, 1000 * kDeg};
  options.search_rad_per_s = 45 * kDeg;
  return options;
}

/// Walks along it as the controller does.
class Walk {
 public:
  Walk(const AimOptions& options, const HeadAngles& from, const HeadAngles& drift)
      : unit(options, kHalfWidth_rad, kHalfHeight_rad), pan_(from.pan_rad), tilt_(from.tilt_rad) {
    unit.begin(from, drift);
  }
  HeadAngles step() {
    const HeadAngles to = unit.way_point();
    if (pan_.angle_rad() == to.pan_rad && tilt_.angle_rad() == to.tilt_rad) unit.reached();
    pan_.advance({unit.way_point().pan_rad, 0}, unit.pan(), 0.01);
    tilt_.advance({unit.way_point().tilt_rad, 0}, unit.tilt(), 0.01);
    return {pan_.angle_rad(), tilt_.angle_rad()};
  }
  int steps_of_a_sweep() const {
    return static_cast<int>(std::chrono::duration<double>(unit.duration()).count() / 0.01);
  }
  Sweep unit;

 private:
  AxisRamp pan_, tilt_;
};

TEST(Sweep, ShowsEverythingWithinReachInTheTimeThatItSaysWhereverItBegins) {
  test::Random random(8);
  for (int trial = 0; trial < 40; ++trial) {
    const HeadAngles from{random.uniform(-60, 60) * kDeg, random.uniform(-40, 30) * kDeg};
    const HeadAngles drift{random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)};
    Walk walk(options(), from, drift);
    EXPECT_LE(walk.unit.duration(), walk.unit.longest());
    constexpr int kPan = 42, kTilt = 26;  // cells of 4 deg
    std::array<std::array<bool, kTilt>, kPan> seen{};
    for (int i = walk.steps_of_a_sweep(); i > 0; --i) {
      const HeadAngles head = walk.step();
      for (int p = 0; p < kPan; ++p)
        for (int t = 0; t < kTilt; ++t) {
          const double pan_rad = (-83 + 4.0 * p) * kDeg, tilt_rad = (-57 + 4.0 * t) * kDeg;
          if (pan_rad > 83 * kDeg || tilt_rad > 47 * kDeg) continue;
          // Whole in the picture: a landmark of 3 deg.
          if (std::abs(pan_rad - head.pan_rad) < kHalfWidth_rad - 0.5 * kDeg &&
              std::abs(tilt_rad - head.tilt_rad) < kHalfHeight_rad - 0.5 * kDeg)
            seen[static_cast<std::size_t>(p)][static_cast<std::size_t>(t)] = true;
        }
    }
    for (int p = 0; p < kPan; ++p)
      for (int t = 0; t < kTilt; ++t) {
        if (-83 + 4 * p > 83 || -57 + 4 * t > 47) continue;
        EXPECT_TRUE(seen[static_cast<std::size_t>(p)][static_cast<std::size_t>(t)])
            << "trial " << trial << ": pan " << -83 + 4 * p << ", tilt " << -57 + 4 * t;
      }
  }
}

TEST(Sweep, BeginsAlongTheRowWhereItWasLostTowardsWhereItWent) {
  for (const double side : {-1.0, 1.0}) {
    Walk walk(options(), {5 * kDeg, -4 * kDeg}, {side * 0.3, 0});
    HeadAngles head;
    for (int i = 0; i < 130; ++i) {
      head = walk.step();
      EXPECT_NEAR(head.tilt_rad, -4 * kDeg, 12 * kDeg) << "in the row next to it";
    }
    EXPECT_GT(side * head.pan_rad, 30 * kDeg);
  }
}

TEST(Sweep, GoesOnWithTheRowsToWhichItWent) {
  for (const double up : {-1.0, 1.0}) {
    Walk walk(options(), {0, -5 * kDeg}, {0, up * 0.3});
    double first_other_row = 0;
    for (int i = walk.steps_of_a_sweep(); i > 0 && first_other_row == 0; --i) {
      const double tilt_rad = walk.step().tilt_rad;
      if (std::abs(tilt_rad + 5 * kDeg) > 15 * kDeg) first_other_row = tilt_rad;
    }
    EXPECT_GT(up * (first_other_row + 5 * kDeg), 0);
  }
}

TEST(Sweep, TakesNoLongerThanItsRowsAndTheWayToTheFirstEndAndSoonestWhereTheWayIsFree) {
  const double row_s = ramp_time_s(120 * kDeg, {-2, 2, 45 * kDeg, 1000 * kDeg});
  const Sweep unit(options(), kHalfWidth_rad, kHalfHeight_rad);
  ASSERT_EQ(unit.row_count(), 4) << "70 deg by four fifths of 36";
  Sweep from_middle = unit, away_from_the_end = unit, towards_the_end = unit;
  from_middle.begin({0, -40 * kDeg}, {});
  towards_the_end.begin({50 * kDeg, -40 * kDeg}, {});
  away_from_the_end.begin({50 * kDeg, -40 * kDeg}, {-0.3, 0});
  const auto s = [](const Sweep& sweep) { return std::chrono::duration<double>(sweep.duration()).count(); };
  // Four rows, three hops of 23.3 deg, half a row to begin with; a fifth of a second for way-points and hops' ramps.
  const double hops_s = 3 * ramp_time_s(70.0 / 3 * kDeg, {-2, 2, 45 * kDeg, 1000 * kDeg});
  EXPECT_LT(s(from_middle), 4.5 * row_s + hops_s + 0.3);
  EXPECT_GT(s(from_middle), 4 * row_s + hops_s);
  EXPECT_LT(s(towards_the_end), s(away_from_the_end));
  EXPECT_LT(s(towards_the_end), s(from_middle));
}

TEST(Sweep, NarrowLensesHaveMoreRowsAndABoundedNumberOfThem) {
  EXPECT_GT(Sweep(options(), 3 * kDeg, 2 * kDeg).row_count(), 20);
  EXPECT_LE(Sweep(options(), 0, 0).row_count(), 72);
}

/// What hid the landmark may have gone behind the head's back.
TEST(Sweep, BeginsAnewAlongTheRowWhereItWasLostAndShowsThatInTimeWheneverItComesBack) {
  for (const double tilt_deg : {-38.0, -15.0, 6.0, 28.0}) {
    Walk walk(options(), {0, tilt_deg * kDeg}, {0.3, 0});
    const int longest = static_cast<int>(std::chrono::duration<double>(walk.unit.longest()).count() / 0.01);
    const double row_s = ramp_time_s(120 * kDeg, walk.unit.pan());
    // A landmark in that row: how long it is out of sight, from round to round.
    for (const double pan_deg : {-70.0, 0.0, 70.0}) {
      int since = 0, most = 0;
      for (int i = 0; i < 4 * longest; ++i, ++since) {
        const HeadAngles head = walk.step();
        const bool is_seen = std::abs(head.pan_rad - pan_deg * kDeg) < kHalfWidth_rad - 0.5 * kDeg &&
                             std::abs(head.tilt_rad - tilt_deg * kDeg) < kHalfHeight_rad - 0.5 * kDeg;
        if (is_seen) most = std::max(most, std::exchange(since, 0));
      }
      EXPECT_LT(std::max(most, since) * 0.01, longest * 0.01 + 2 * row_s) << tilt_deg << ' ' << pan_deg;
    }
  }
}

}  // namespace
}  // namespace ninedot
