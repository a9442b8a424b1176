#include "aim/head_kinematics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/random.h"

namespace ninedot {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double kDeg = std::numbers::pi / 180;

/// Camera to the camera of a head that stands at 0, 0: pan about "up" (-y), then tilt about "right" (x).
Eigen::Matrix3d turned(const HeadAngles& head) {
  return (AngleAxisd(head.pan_rad, -Vector3d::UnitY()) * AngleAxisd(head.tilt_rad, Vector3d::UnitX()))
      .toRotationMatrix();
}

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

TEST(AnglesTowards, GoOnPastHalfATurnInsteadOfAllTheWayBack) {
  const HeadAngles goal = angles_towards({-0.2, 0, 1}, {0, 0, 1}, {179 * kDeg, 0});
  EXPECT_NEAR(goal.pan_rad, 179 * kDeg + std::atan(0.2), 1e-9);
}

/// A head whose axes miss each other and the camera by centimetres, and whose camera looks askew.
BodyGeometry crooked() {
  BodyGeometry body;
  body.pan_axis_m = {0.3, -0.1, 0.5};
  body.mount_rpy_rad = {0.02, -0.3, 1.2};
  body.tilt_axis_m = {0.03, -0.02, 0.08};
  body.camera_m = {0.05, 0.04, 0.06};
  body.camera_rpy_rad = {0.03, -0.05, 0.04};
  return body;
}

CameraModel off_centre_camera() {
  CameraModel camera;
  camera.cx_px = 350, camera.cy_px = 215;
  return camera;
}

/// Beside geometry/body.h, which knows nothing of aiming.
TEST(HeadKinematics, BringAPointIntoTheMiddleThoughTheAxesDoNotMeet) {
  const HeadKinematics kinematics(off_centre_camera(), crooked());
  test::Random random(11);
  for (int i = 0; i < 300; ++i) {
    const HeadAngles seen_from{random.uniform(-1, 1), random.uniform(-0.6, 0.6)};
    const Vector3d seen_m(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3), random.uniform(0.6, 4));
    const Vector3d body_m = camera_on_body(crooked(), seen_from).T_body_camera * seen_m;
    const HeadAngles goal = kinematics.towards(kinematics.in_base(seen_m, seen_from), seen_from);
    const Vector3d there_m = camera_on_body(crooked(), goal).T_body_camera.inverse() * body_m;
    const Eigen::Vector2d px = off_centre_camera().pixel_from_normalised(there_m.hnormalized());
    EXPECT_LT((px - Eigen::Vector2d(319.5, 239.5)).norm(), 0.01) << i;
  }
}

TEST(HeadKinematics, APointStaysWhereItIsWhileTheHeadTurns) {
  const HeadKinematics kinematics(off_centre_camera(), crooked());
  const Vector3d body_m = camera_on_body(crooked(), {}).T_body_camera * Vector3d(0.2, -0.1, 1.5);
  const Vector3d base_m = kinematics.in_base(Vector3d(0.2, -0.1, 1.5), {});
  for (const HeadAngles& head : {HeadAngles{0.4, -0.3}, HeadAngles{-1, 0.5}}) {
    const Vector3d seen_m = camera_on_body(crooked(), head).T_body_camera.inverse() * body_m;
    EXPECT_LT((kinematics.in_base(seen_m, head) - base_m).norm(), 1e-12);
  }
}

TEST(HeadKinematics, KnowHowMuchAPictureShowsAndHowFarAPointIsFromItsMiddle) {
  const HeadKinematics kinematics(CameraModel{}, {});
  EXPECT_NEAR(kinematics.half_width_rad(), std::atan(319.5 / 720), 1e-6);
  EXPECT_NEAR(kinematics.half_height_rad(), std::atan(239.5 / 720), 1e-6);
  EXPECT_NEAR(kinematics.off_centre_rad({std::tan(0.2), 0, 1}), 0.2, 1e-9);
  EXPECT_NEAR(kinematics.off_centre_rad({0, 0, -1}), std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace ninedot
