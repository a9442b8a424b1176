#include "aim/aimer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/random.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double kDeg = std::numbers::pi / 180;

/// Camera to the camera of a head that stands at 0, 0: pan about "up" (-y), then tilt about "right" (x).
Eigen::Matrix3d turned(const HeadAngles& head) {
  return (AngleAxisd(head.pan_rad, -Vector3d::UnitY()) * AngleAxisd(head.tilt_rad, Vector3d::UnitX()))
      .toRotationMatrix();
}

AimOptions wide() {
  AimOptions options;
  options.pan = {-3, 3, 1};
  options.tilt = {-1.4, 1.4, 1};
  options.gain = 1;
  return options;
}

AimSight straight_ahead_but(double left_rad, double up_rad, MonoTime exposed_at) {
  const Vector3d direction = turned({left_rad, up_rad}) * Vector3d::UnitZ();
  return {true, exposed_at, direction};
}

constexpr MonoTime kStart{100s};
constexpr auto kFrame = 20ms;

TEST(AnglesTowards, BringTheTargetIntoTheCentreDirectionFromWhereverTheHeadStands) {
  test::Random random(5);
  for (int i = 0; i < 500; ++i) {
    const HeadAngles head{random.uniform(-1, 1), random.uniform(-0.7, 0.7)};
    const Vector3d target_base = turned({random.uniform(-1.5, 1.5), random.uniform(-0.9, 0.9)}) * Vector3d(0, 0, 3);
    const Vector3d centre = Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 1).normalized();
    const HeadAngles goal = angles_towards(turned(head).transpose() * target_base, centre, head);
    const Vector3d seen = (turned(goal).transpose() * target_base).normalized();
    EXPECT_LT((seen - centre).norm(), 1e-9) << "pan " << goal.pan_rad << ", tilt " << goal.tilt_rad;
  }
}

TEST(AnglesTowards, ArePositiveToTheLeftAndUpwards) {
  const HeadAngles goal = angles_towards({-0.1, -0.2, 1}, {0, 0, 1}, {});
  EXPECT_NEAR(goal.pan_rad, std::atan(0.1), 1e-9);
  EXPECT_GT(goal.tilt_rad, 0.19);
}

TEST(Aimer, TurnsNoFasterThanTheAxisMay) {
  Aimer unit(CameraModel{}, wide());
  HeadAngles head;
  const Vector3d target = turned({0.9, -0.5}) * Vector3d::UnitZ();
  for (int i = 0; i < 100; ++i) {
    const MonoTime now = kStart + i * kFrame;
    const AimStep step = unit.step(now, head, {true, now, turned(head).transpose() * target}, {}, false);
    EXPECT_LE(std::abs(step.command.pan_rad - head.pan_rad), 0.02 + 1e-12);
    EXPECT_LE(std::abs(step.command.tilt_rad - head.tilt_rad), 0.02 + 1e-12);
    head = step.command;
  }
  // The middle of the picture is half a pixel from the optical axis of the default camera.
  EXPECT_NEAR(head.pan_rad, 0.9, 1e-3);
  EXPECT_NEAR(head.tilt_rad, -0.5, 1e-3);
}

TEST(Aimer, StaysWithinTheDeadBand) {
  AimOptions options = wide();
  options.dead_band_rad = 1 * kDeg;
  Aimer unit(CameraModel{}, options);
  unit.step(kStart, {}, {}, {}, false);
  const AimStep within = unit.step(kStart + kFrame, {}, straight_ahead_but(0.9 * kDeg, 0, kStart + kFrame), {}, false);
  EXPECT_EQ(within.command.pan_rad, 0);
  const AimStep beyond =
      unit.step(kStart + 2 * kFrame, {}, straight_ahead_but(1.2 * kDeg, 0, kStart + 2 * kFrame), {}, false);
  EXPECT_GT(beyond.command.pan_rad, 0.01);
}

TEST(Aimer, StaysWithoutAValidPose) {
  Aimer unit(CameraModel{}, wide());
  unit.step(kStart, {}, {}, {}, false);
  AimSight sight = straight_ahead_but(0.5, 0.5, kStart + kFrame);
  sight.valid = false;
  const AimStep step = unit.step(kStart + kFrame, {}, sight, {}, false);
  EXPECT_EQ(step.command.pan_rad, 0);
  EXPECT_EQ(step.command.tilt_rad, 0);
}

TEST(Aimer, SaturatesAtTheLimitsAndSaysSo) {
  AimOptions options = wide();
  options.pan = {-0.1, 0.1, 1};
  Aimer unit(CameraModel{}, options);
  HeadAngles head;
  bool limited = false;
  for (int i = 0; i < 20; ++i) {
    const AimStep step = unit.step(kStart + i * kFrame, head, {}, {false, {0.4, 0.05}}, false);
    EXPECT_LE(step.command.pan_rad, 0.1);
    head = step.command;
    limited = step.limited;
  }
  EXPECT_TRUE(limited);
  EXPECT_EQ(head.pan_rad, 0.1);
  EXPECT_EQ(head.tilt_rad, 0.05);
  EXPECT_FALSE(unit.step(kStart + 30 * kFrame, head, {}, {false, {0.05, 0.05}}, false).limited);
}

TEST(Aimer, GoesExactlyToASetPointWhateverTheDeadBand) {
  AimOptions options = wide();
  options.dead_band_rad = 0.1;
  options.gain = 0.2;
  Aimer unit(CameraModel{}, options);
  HeadAngles head;
  for (int i = 0; i < 20; ++i) head = unit.step(kStart + i * kFrame, head, {}, {false, {0.05, -0.03}}, false).command;
  EXPECT_EQ(head.pan_rad, 0.05);
  EXPECT_EQ(head.tilt_rad, -0.03);
}

TEST(Aimer, ReckonsFromWhereTheHeadStoodWhenTheFrameWasExposed) {
  // A frame three steps old, in which the target was seen straight ahead of where the head stood then.
  Aimer unit(CameraModel{}, wide());
  HeadAngles head;
  for (int i = 0; i < 10; ++i) {
    const MonoTime now = kStart + i * kFrame;
    head.pan_rad = 0.01 * i;
    unit.step(now, head, {}, {false, {1, 0}}, false);
  }
  EXPECT_NEAR(unit.track().at(kStart + 4 * kFrame + 1ms).pan_rad, 0.04, 1e-12);
  EXPECT_NEAR(unit.track().at(kStart - 1s).pan_rad, 0, 1e-12) << "where it stood at the start";
  const AimSight sight = straight_ahead_but(0, 0, kStart + 4 * kFrame + 1ms);
  HeadAngles goal;
  for (int i = 10; i < 14; ++i) goal = unit.step(kStart + i * kFrame, head, sight, {true, {}}, false).command;
  EXPECT_LT(goal.pan_rad, 0.15) << "the command went on towards 1 until the order changed";
}

TEST(Aimer, DoesNotMoveWhileInhibitedAndGoesOnFromWhereTheHeadStands) {
  Aimer unit(CameraModel{}, wide());
  HeadAngles head{0.3, 0.1};
  for (int i = 0; i < 5; ++i) {
    const AimStep step = unit.step(kStart + i * kFrame, head, {}, {false, {1, 1}}, true);
    EXPECT_EQ(step.command.pan_rad, head.pan_rad);
    EXPECT_EQ(step.command.tilt_rad, head.tilt_rad);
  }
  const AimStep step = unit.step(kStart + 5 * kFrame, head, {}, {false, {1, 1}}, false);
  EXPECT_NEAR(step.command.pan_rad, 0.32, 1e-9);
}

TEST(Aimer, MakesNoJumpAfterALongPause) {
  Aimer unit(CameraModel{}, wide());
  unit.step(kStart, {}, {}, {false, {2, 0}}, false);
  EXPECT_LE(unit.step(kStart + 60s, {}, {}, {false, {2, 0}}, false).command.pan_rad, 0.1 + 1e-12);
}

}  // namespace
}  // namespace ninedot
