#include "config/head_options.h"

#include <gtest/gtest.h>

#include <numbers>

namespace ninedot {
namespace {

constexpr double kDeg = std::numbers::pi / 180;

TEST(HeadOptions, TurnAnglesIntoPulsesByCentreSlopeAndDirection) {
  PanTiltConfig config;
  config.driver = "sysfs-pwm";
  config.pan.centre_us = 1480;
  config.tilt.direction = "reversed";
  const ServoAxes axes = servo_axes(config);
  EXPECT_NEAR(axes.pan.output_at(10 * kDeg).value, 1580, 1e-6);
  EXPECT_NEAR(axes.tilt.output_at(10 * kDeg).value, 1400, 1e-6);
  EXPECT_EQ(axes.pan.output_at(80 * kDeg).value, 2000);
  EXPECT_TRUE(axes.pan.output_at(80 * kDeg).limited);
}

TEST(HeadOptions, PreferAMeasuredCalibration) {
  PanTiltConfig config;
  config.driver = "gpio";
  config.tilt.calibration = {{-30 * kDeg, 1820}, {0, 1510}, {30 * kDeg, 1190}};
  EXPECT_NEAR(servo_axes(config).tilt.output_at(15 * kDeg).value, 1350, 1e-6);
}

TEST(HeadOptions, TurnAnglesIntoTheStepsOfAViscaCameraWithinItsOwnRange) {
  PanTiltConfig config;
  config.driver = "visca";
  config.pan.min_deg = -120;
  config.pan.max_deg = 120;
  const ServoAxes axes = servo_axes(config);
  EXPECT_NEAR(axes.pan.output_at(10 * kDeg).value, -88, 1e-6) << "the camera counts to the right";
  EXPECT_NEAR(axes.tilt.output_at(10 * kDeg).value, 120, 1e-6);
  EXPECT_EQ(axes.pan.output_at(110 * kDeg).value, -880);
  EXPECT_EQ(axes.tilt.output_at(40 * kDeg).value, 300);
  EXPECT_TRUE(axes.tilt.output_at(40 * kDeg).limited);
  config.pan.direction = "reversed";
  EXPECT_NEAR(servo_axes(config).pan.output_at(10 * kDeg).value, 88, 1e-6);
  config.tilt.neutral_deg = 30;
  ConfigProblems problems;
  problems.lines = {{"pan_tilt.tilt.neutral_deg", 7}};
  check_head_axes(config, problems);
  ASSERT_EQ(problems.list.size(), 1U);
  EXPECT_EQ(problems.list[0].line, 7);
  EXPECT_EQ(problems.list[0].what, "'neutral_deg' is 30, beyond the camera's own range");
}

TEST(HeadOptions, StartWhereTheConfigurationSays) {
  PanTiltConfig config;
  config.follow = false;
  config.pan.neutral_deg = 20;
  config.dead_band_deg = 0.5;
  EXPECT_FALSE(first_order(config).follow);
  EXPECT_NEAR(first_order(config).set_point.pan_rad, 20 * kDeg, 1e-12);
  EXPECT_NEAR(aim_options(config).neutral.pan_rad, 20 * kDeg, 1e-12);
  EXPECT_NEAR(aim_options(config).dead_band_rad, 0.5 * kDeg, 1e-12);
}

}  // namespace
}  // namespace ninedot
