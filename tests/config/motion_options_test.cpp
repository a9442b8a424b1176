#include "programs/assembly/motion_options.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "tests/config/config_text.h"

namespace ninedot {
namespace {

using test::error_of;
using test::parse;

TEST(MotionOptions, OfAnEmptyFileAreTheFiltersOwnAndACameraAtTheBodysOrigin) {
  const PoseFilterOptions own, read = pose_filter_options(parse(""));
  EXPECT_EQ(read.acceleration_sigma_m_s2, own.acceleration_sigma_m_s2);
  EXPECT_EQ(read.angular_acceleration_sigma_rad_s2, own.angular_acceleration_sigma_rad_s2);
  EXPECT_EQ(read.common_share, own.common_share);
  EXPECT_EQ(read.landmark.ring_radius_m, own.landmark.ring_radius_m);
  EXPECT_EQ(read.landmark.dot_radius_m, own.landmark.dot_radius_m);
  EXPECT_EQ(read.landmark.centre_radius_m, own.landmark.centre_radius_m);
  const CameraOnBody camera = camera_on_body(body_geometry(parse("").body), {});
  EXPECT_TRUE(camera.T_body_camera.translation_m.isZero());
  EXPECT_TRUE(camera.covariance.isZero());
}

/// A head turns its camera faster than a robot does: 60 degrees per second within the quarter of a second.
TEST(MotionOptions, LeaveRoomForAHeadsOwnTurns) {
  const PoseFilterOptions own,
      slow = pose_filter_options(parse("[pan_tilt]\ndriver = \"simulated\"\n")),
      fast = pose_filter_options(parse("[pan_tilt]\ndriver = \"simulated\"\n[pan_tilt.tilt]\n"
                                       "slew_deg_per_s = 350\nacceleration_deg_per_s2 = 900\n"));
  EXPECT_DOUBLE_EQ(slow.angular_acceleration_sigma_rad_s2,
                   std::hypot(own.angular_acceleration_sigma_rad_s2, 240 * kRadPerDeg));
  EXPECT_DOUBLE_EQ(fast.angular_acceleration_sigma_rad_s2,
                   std::hypot(own.angular_acceleration_sigma_rad_s2, 900 * kRadPerDeg));
}

TEST(MotionOptions, AreReadInMetresAndRadians) {
  const Config config = parse(R"([track]
acceleration_sigma_m_s2 = 2
angular_acceleration_sigma_deg_s2 = 90
common_share = 0.25
[body]
pan_axis_mm = [100, -20, 900]
mount_rpy_deg = [1, -2, 90]
tilt_axis_mm = [10, 11, 12]
camera_mm = [30, 31, 32]
camera_rpy_deg = [0.5, 0.6, 0.7]
pan_sigma_deg = 0.1
tilt_sigma_deg = 0.2
mount_sigma_mm = 3
mount_sigma_deg = 0.4
)");
  const PoseFilterOptions options = pose_filter_options(config);
  EXPECT_EQ(options.acceleration_sigma_m_s2, 2);
  EXPECT_DOUBLE_EQ(options.angular_acceleration_sigma_rad_s2, 90 * kRadPerDeg);
  EXPECT_EQ(options.common_share, 0.25);
  const BodyGeometry body = body_geometry(config.body);
  EXPECT_TRUE(body.pan_axis_m.isApprox(Eigen::Vector3d(0.1, -0.02, 0.9)));
  EXPECT_TRUE(body.mount_rpy_rad.isApprox(Eigen::Vector3d(1, -2, 90) * kRadPerDeg));
  EXPECT_TRUE(body.tilt_axis_m.isApprox(Eigen::Vector3d(0.01, 0.011, 0.012)));
  EXPECT_TRUE(body.camera_m.isApprox(Eigen::Vector3d(0.03, 0.031, 0.032)));
  EXPECT_TRUE(body.camera_rpy_rad.isApprox(Eigen::Vector3d(0.5, 0.6, 0.7) * kRadPerDeg));
  EXPECT_DOUBLE_EQ(body.pan_sigma_rad, 0.1 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(body.tilt_sigma_rad, 0.2 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(body.mount_sigma_m, 0.003);
  EXPECT_DOUBLE_EQ(body.mount_sigma_rad, 0.4 * kRadPerDeg);
}

TEST(MotionOptions, AreRefusedOutOfRangeWithTheirLine) {
  EXPECT_EQ(error_of("[track]\nacceleration_sigma_m_s2 = 0\n"),
            "t.toml:2: 'acceleration_sigma_m_s2' is 0; write 0.001 to 100 m/s^2");
  EXPECT_EQ(error_of("[track]\ncommon_share = 1\n"), "t.toml:2: 'common_share' is 1; write 0 to 0.9");
  EXPECT_EQ(error_of("[body]\ncamera_mm = [1, 2]\n"), "t.toml:2: 'camera_mm' must be three numbers, [x, y, z]");
  EXPECT_EQ(error_of("[body]\npan_sigma_deg = -1\n"), "t.toml:2: 'pan_sigma_deg' is -1; write 0 to 30 deg");
}

}  // namespace
}  // namespace ninedot
