#include "config/head_options.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numbers>
#include <tuple>
#include <utility>

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

TEST(HeadOptions, TurnAnglesIntoThePositionsOfSmartServosWithinTheirOwnRange) {
  for (const auto& [driver, straight_ahead, turn, last] : {std::tuple("dynamixel", 2048.0, 4096.0, 4095.0),
                                                           {"feetech-sts", 2048, 4096, 4095},
                                                           {"feetech-scs", 512, 1228.8, 1023}}) {
    PanTiltConfig config;
    config.driver = driver;
    config.pan.min_deg = config.tilt.min_deg = -180;
    config.pan.max_deg = config.tilt.max_deg = 180;
    config.tilt.direction = "reversed";
    const ServoAxes axes = servo_axes(config);
    EXPECT_NEAR(axes.pan.output_at(0).value, straight_ahead, 1e-6) << driver;
    EXPECT_NEAR(axes.pan.output_at(36 * kDeg).value, straight_ahead + turn / 10, 1e-6) << driver;
    EXPECT_NEAR(axes.tilt.output_at(36 * kDeg).value, straight_ahead - turn / 10, 1e-6) << driver;
    EXPECT_EQ(axes.pan.output_at(180 * kDeg).value, last) << driver;
    EXPECT_EQ(axes.tilt.output_at(180 * kDeg).value, 0) << driver;
    config.pan.max_deg = 20;
    EXPECT_NEAR(servo_axes(config).pan.output_at(90 * kDeg).value, straight_ahead + turn / 18, 1e-6)
        << "the angles' own limit: " << driver;
    config.pan.calibration = {{0, 100}, {100 * kDeg, 600}};
    EXPECT_NEAR(servo_axes(config).pan.output_at(10 * kDeg).value, 150, 1e-6) << driver;
    config.pan.calibration = {{0, -100}, {100 * kDeg, 600}};
    ConfigProblems problems;
    check_head_axes(config, problems);
    ASSERT_EQ(problems.list.size(), 1U);
    EXPECT_EQ(problems.list[0].what, "'neutral_deg' is 0, beyond the servo's own range");
  }
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
  EXPECT_NEAR(start_angles(config).pan_rad, 20 * kDeg, 1e-12);
  EXPECT_NEAR(aim_options(config).park.pan_rad, 20 * kDeg, 1e-12);
  config.pan.start_deg = -10;
  config.tilt.park_deg = 15;
  EXPECT_NEAR(start_angles(config).pan_rad, -10 * kDeg, 1e-12);
  EXPECT_NEAR(aim_options(config).park.tilt_rad, 15 * kDeg, 1e-12);
}

TEST(HeadOptions, OfAimingAreInTheUnitsOfInside) {
  PanTiltConfig config;
  config.pan.acceleration_deg_per_s2 = 500;
  config.head_delay_ms = 12.5;
  config.coast_ms = 700;
  config.park_after_s = 90;
  config.search = false;
  config.search_at_start = true;
  config.search_deg_per_s = 30;
  config.hand_over_margin_percent = 25;
  config.landmark = "id";
  config.landmark_id = 9;
  BodyGeometry body;
  body.camera_m = {0.1, 0, 0};
  const AimOptions options = aim_options(config, body);
  EXPECT_NEAR(options.pan.acceleration_rad_per_s2, 500 * kDeg, 1e-12);
  EXPECT_EQ(options.head_delay, std::chrono::microseconds(12500));
  EXPECT_EQ(options.coast, std::chrono::milliseconds(700));
  EXPECT_EQ(options.park_after, std::chrono::seconds(90));
  EXPECT_FALSE(options.search);
  EXPECT_TRUE(options.search_at_start);
  EXPECT_NEAR(options.search_rad_per_s, 30 * kDeg, 1e-12);
  EXPECT_NEAR(options.hand_over_margin, 0.25, 1e-12);
  EXPECT_EQ(options.landmark, LandmarkChoice::kById);
  EXPECT_EQ(options.landmark_id, 9);
  EXPECT_EQ(options.body.camera_m.x(), 0.1);
  for (const auto& [word, choice] :
       {std::pair("hand-over", LandmarkChoice::kHandOver), std::pair("nearest", LandmarkChoice::kNearest),
        std::pair("reported", LandmarkChoice::kReported)}) {
    config.landmark = word;
    EXPECT_EQ(aim_options(config).landmark, choice);
  }
}

TEST(HeadOptions, PlacesOfItsOwnLieWithinTheAxesRange) {
  PanTiltConfig config;
  config.driver = "gpio";
  config.pan.start_deg = 60;
  config.tilt.park_deg = -50;
  ConfigProblems problems;
  problems.lines = {{"pan_tilt.pan.start_deg", 4}, {"pan_tilt.tilt.park_deg", 9}};
  check_head_axes(config, problems);
  ASSERT_EQ(problems.list.size(), 2U);
  EXPECT_EQ(problems.list[0].what, "'start_deg' is 60; write -45 to 45, min_deg to max_deg");
  EXPECT_EQ(problems.list[1].line, 9);
}

}  // namespace
}  // namespace ninedot
