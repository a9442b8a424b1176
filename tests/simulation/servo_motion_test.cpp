// The servo against the closed forms of motion with limited acceleration and speed.
#include "drivers/simulation/servo_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/units.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

const MonoTime kStart = mono_from_ns(1'000'000'000);

MonoTime after(double seconds) { return kStart + std::chrono::nanoseconds(std::llround(seconds * 1e9)); }

/// A hobby servo: 0.17 s for 60 deg.
ServoDynamics hobby() {
  ServoDynamics dynamics;
  dynamics.min_rad = -90 * kRadPerDeg;
  dynamics.max_rad = 90 * kRadPerDeg;
  dynamics.speed_rad_s = 353 * kRadPerDeg;
  dynamics.acceleration_rad_s2 = 6000 * kRadPerDeg;
  return dynamics;
}

/// From rest to rest over `way`, t after the start: speeds up by `a` to `v` at most, and brakes likewise.
double trapezium(double way, double a, double v, double t) {
  const double top = std::min(v, std::sqrt(a * way)), rise = top / a, ramp = top * rise / 2;
  const double cruise = (way - 2 * ramp) / top, end = 2 * rise + cruise;
  if (t <= 0) return 0;
  if (t < rise) return a * t * t / 2;
  if (t < rise + cruise) return ramp + top * (t - rise);
  if (t < end) return way - a * (end - t) * (end - t) / 2;
  return way;
}

TEST(ServoMotion, FollowsTheClosedFormOfAStepWithLimitedSpeedAndAcceleration) {
  // 5 deg never reach the full speed, 60 deg do.
  for (const double way_deg : {0.2, 5.0, 20.0, 60.0, -60.0}) {
    const ServoDynamics dynamics = hobby();
    ServoMotion servo(dynamics, 0, kStart);
    const double way_rad = way_deg * kRadPerDeg;
    servo.command(kStart, way_rad);
    for (double t_s = 0; t_s < 0.4; t_s += 0.0037) {
      servo.advance(after(t_s));
      const double expected_rad =
          std::copysign(trapezium(std::abs(way_rad), dynamics.acceleration_rad_s2, dynamics.speed_rad_s, t_s), way_rad);
      EXPECT_NEAR(servo.angle_rad() * kDegPerRad, expected_rad * kDegPerRad, 0.03) << way_deg << " deg at " << t_s;
    }
    EXPECT_DOUBLE_EQ(servo.angle_rad(), way_rad);
    EXPECT_EQ(servo.speed_rad_s(), 0);
  }
}

TEST(ServoMotion, StopsAtTheEdgeOfItsDeadBandAndIgnoresWhatIsWithin) {
  ServoDynamics dynamics = hobby();
  dynamics.dead_band_rad = 1 * kRadPerDeg;
  ServoMotion servo(dynamics, 0, kStart);
  servo.command(kStart, 20 * kRadPerDeg);
  servo.advance(after(1));
  EXPECT_NEAR(servo.angle_rad() * kDegPerRad, 19, 1e-6);
  servo.command(after(1), 18.1 * kRadPerDeg);
  servo.advance(after(2));
  EXPECT_NEAR(servo.angle_rad() * kDegPerRad, 19, 1e-6) << "within the dead band";
  servo.command(after(2), 17.5 * kRadPerDeg);
  servo.advance(after(3));
  EXPECT_NEAR(servo.angle_rad() * kDegPerRad, 18.5, 1e-6);
}

TEST(ServoMotion, HearsMultiplesOfItsResolution) {
  ServoDynamics dynamics = hobby();
  dynamics.resolution_rad = 0.5 * kRadPerDeg;
  ServoMotion servo(dynamics, 0, kStart);
  servo.command(kStart, 7.24 * kRadPerDeg);
  servo.advance(after(1));
  EXPECT_NEAR(servo.angle_rad() * kDegPerRad, 7.0, 1e-9);
  servo.command(after(1), 7.26 * kRadPerDeg);
  servo.advance(after(2));
  EXPECT_NEAR(servo.angle_rad() * kDegPerRad, 7.5, 1e-9);
}

TEST(ServoMotion, HearsEachCommandAfterItsDelay) {
  ServoDynamics dynamics = hobby();
  dynamics.delay = 40ms;
  ServoMotion servo(dynamics, 0, kStart);
  servo.command(kStart, 10 * kRadPerDeg);
  servo.command(after(0.01), 60 * kRadPerDeg);
  servo.advance(after(0.0399));
  EXPECT_EQ(servo.angle_rad(), 0);
  servo.advance(after(0.05));
  EXPECT_NEAR(servo.angle_rad(), dynamics.acceleration_rad_s2 * 0.01 * 0.01 / 2, 1e-4);
  // As if it had been told 60 deg at once: after 10 ms both motions still speed up.
  servo.advance(after(0.04 + 0.1));
  EXPECT_NEAR(servo.angle_rad(), trapezium(60 * kRadPerDeg, dynamics.acceleration_rad_s2, dynamics.speed_rad_s, 0.1),
              5e-4);
}

TEST(ServoMotion, MovesTheCameraOnceThePlayIsTakenUp) {
  ServoDynamics dynamics = hobby();
  dynamics.backlash_rad = 2 * kRadPerDeg;
  ServoMotion servo(dynamics, 0, kStart);
  const std::vector<std::pair<double, double>> told_and_seen_deg{{0.9, 0}, {10, 9}, {8.5, 9}, {7, 8}, {20, 19}};
  double t_s = 0;
  for (const auto& [told_deg, seen_deg] : told_and_seen_deg) {
    servo.command(after(t_s), told_deg * kRadPerDeg);
    t_s += 1;
    servo.advance(after(t_s));
    EXPECT_NEAR(servo.shaft_rad() * kDegPerRad, told_deg, 1e-9);
    EXPECT_NEAR(servo.angle_rad() * kDegPerRad, seen_deg, 1e-9);
  }
}

TEST(ServoMotion, StopsAtItsStops) {
  ServoDynamics dynamics = hobby();
  dynamics.max_rad = 30 * kRadPerDeg;
  ServoMotion servo(dynamics, 0, kStart);
  servo.command(kStart, 60 * kRadPerDeg);
  servo.advance(after(1));
  EXPECT_DOUBLE_EQ(servo.angle_rad(), dynamics.max_rad);
}

TEST(ServoMotion, NeverExceedsItsLimitsWhateverItIsTold) {
  const ServoDynamics dynamics = hobby();
  ServoMotion servo(dynamics, 0, kStart);
  double before_rad = 0, speed_before_rad_s = 0;
  constexpr double kTick_s = 0.001;
  for (int i = 0; i < 4000; ++i) {
    const double t_s = i * kTick_s;
    if (i % 23 == 0) servo.command(after(t_s), 40 * kRadPerDeg * std::sin(0.37 * i * i));
    servo.advance(after(t_s + kTick_s));
    EXPECT_LE(std::abs(servo.angle_rad() - before_rad), dynamics.speed_rad_s * kTick_s * (1 + 1e-9));
    EXPECT_LE(std::abs(servo.speed_rad_s() - speed_before_rad_s), dynamics.acceleration_rad_s2 * kTick_s * 1.26);
    before_rad = servo.angle_rad();
    speed_before_rad_s = servo.speed_rad_s();
  }
}

TEST(ServoMotion, IsTheSameHoweverOftenItIsAsked) {
  ServoMotion often(hobby(), 0, kStart), seldom(hobby(), 0, kStart);
  often.command(kStart, 0.7);
  seldom.command(kStart, 0.7);
  for (int i = 0; i < 1000; ++i) often.advance(after(i * 0.000113));
  often.advance(after(0.113));
  seldom.advance(after(0.113));
  EXPECT_NEAR(often.angle_rad(), seldom.angle_rad(), 1e-5);
}

TEST(ServoMotion, LosesNoNewestCommandWhenMoreAreOnTheirWayThanItHolds) {
  ServoDynamics dynamics = hobby();
  dynamics.delay = 1s;
  ServoMotion servo(dynamics, 0, kStart);
  for (int i = 0; i < 3000; ++i) servo.command(after(i * 1e-5), i == 2999 ? 0.5 : -0.5);
  servo.advance(after(3));
  EXPECT_DOUBLE_EQ(servo.angle_rad(), 0.5);
}

}  // namespace
}  // namespace ninedot
