// The whole loop: a rendered picture as the turned camera sees it -> pose -> aiming step -> simulated head -> next
// picture.
#include "pipeline/head_control.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <atomic>
#include <cmath>
#include <numbers>

#include "drivers/servo/simulated_pan_tilt.h"
#include "pipeline/localiser.h"
#include "tests/support/process_picture.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDeg = std::numbers::pi / 180;
constexpr auto kFrame = 28ms;

class Switch final : public DigitalInput {
 public:
  bool is_active() const noexcept override { return active; }
  std::atomic<bool> active{false};
};

ServoAxes axes() {
  constexpr std::array kPoints{AxisPoint{-90 * kDeg, 600}, AxisPoint{90 * kDeg, 2400}};
  return {ServoAxis(kPoints, 1000, 2000), ServoAxis(kPoints, 1000, 2000)};
}

AimOptions aim_options() {
  AimOptions options;
  options.pan = options.tilt = {-50 * kDeg, 50 * kDeg, 60 * kDeg};
  options.dead_band_rad = 0.2 * kDeg;
  return options;
}

/// A head in front of the landmark which, straight ahead, has it far from the middle of its picture.
class Rig {
 public:
  explicit Rig(const AimOrder& order = {})
      : head(axes(), {}), control(CameraModel{}, aim_options(), head, &inhibit, order), localiser_(CameraModel{}, {}) {
    straight_ = test::look_at_landmark(
        {.distance_m = 2, .tilt_rad = 10 * kDeg, .off_axis_x_rad = -15 * kDeg, .off_axis_y_rad = 10 * kDeg});
  }

  void one_frame() {
    const HeadAngles at = head.state().angles;
    test::Scene scene;
    scene.camera = turned(at);
    const test::Picture picture = test::render(scene, 7);
    test::process_picture(localiser_, picture.view(), now_, frame_++, report);
    control.aim(now_ + 10ms, report);
    control.move();
    now_ += kFrame;
  }

  /// Angle between P9 and the optical axis, from the truth alone.
  double off_axis_rad() const {
    const test::CameraPose pose = turned(head.state().angles);
    const auto& [w, x, y, z] = pose.quaternion_wxyz;
    const Vector3d p9 = Quaterniond(w, x, y, z).conjugate() * -Vector3d(pose.position_m.data());
    return std::atan2(std::hypot(p9.x(), p9.y()), p9.z());
  }

  struct CountingHead : SimulatedPanTilt {
    using SimulatedPanTilt::SimulatedPanTilt;
    void stop() noexcept override { ++stops; }
    int stops = 0;
  } head;
  Switch inhibit;
  HeadControl control;
  Report report;

 private:
  test::CameraPose turned(const HeadAngles& at) const {
    test::CameraPose pose = straight_;
    const auto& [w, x, y, z] = straight_.quaternion_wxyz;
    const Quaterniond q = Quaterniond(w, x, y, z) * AngleAxisd(at.pan_rad, -Vector3d::UnitY()) *
                          AngleAxisd(at.tilt_rad, Vector3d::UnitX());
    pose.quaternion_wxyz = {q.w(), q.x(), q.y(), q.z()};
    return pose;
  }

  test::CameraPose straight_;
  Localiser localiser_;
  MonoTime now_{1s};
  std::uint64_t frame_ = 0;
};

TEST(HeadControl, BringsTheLandmarkToTheMiddleOfThePictureAndKeepsItThere) {
  Rig rig;
  EXPECT_GT(rig.off_axis_rad(), 15 * kDeg);
  for (int i = 0; i < 40; ++i) rig.one_frame();
  for (int i = 0; i < 5; ++i) {
    rig.one_frame();
    EXPECT_TRUE(rig.report.valid);
    // The dead band of each axis, and half a pixel from the optical axis to the middle of the picture.
    EXPECT_LT(rig.off_axis_rad(), 0.35 * kDeg);
  }
  EXPECT_TRUE(rig.report.has_head);
  EXPECT_GT(rig.report.pan_rad, 10 * kDeg) << "the landmark was on the left";
  EXPECT_LT(rig.report.tilt_rad, -5 * kDeg) << "and below the middle";
  EXPECT_FALSE(rig.report.servo_limit || rig.report.servo_fault || rig.report.inhibited);
}

TEST(HeadControl, StopsWithinOneFrameOfTheInhibitInput) {
  Rig rig;
  for (int i = 0; i < 3; ++i) rig.one_frame();
  rig.inhibit.active = true;
  const HeadAngles before = rig.head.state().angles;
  rig.control.move();
  for (int i = 0; i < 3; ++i) rig.one_frame();
  EXPECT_EQ(rig.head.state().angles.pan_rad, before.pan_rad);
  EXPECT_TRUE(rig.report.inhibited);
  EXPECT_EQ(rig.head.stops, 1) << "said once, not with every frame";
  rig.inhibit.active = false;
  for (int i = 0; i < 40; ++i) rig.one_frame();
  EXPECT_LT(rig.off_axis_rad(), 0.35 * kDeg);
}

TEST(HeadControl, GoesToASetPointAndSaysWhenItLiesBeyondTheLimits) {
  Rig rig({false, {}});
  rig.one_frame();
  EXPECT_EQ(rig.head.state().angles.pan_rad, 0);
  rig.control.order({false, {-70 * kDeg, 5 * kDeg}});
  for (int i = 0; i < 60; ++i) rig.control.aim(MonoTime(2s) + i * kFrame, rig.report), rig.control.move();
  EXPECT_NEAR(rig.head.state().angles.pan_rad, -50 * kDeg, 1e-9);
  EXPECT_NEAR(rig.head.state().angles.tilt_rad, 5 * kDeg, 1e-9);
  EXPECT_TRUE(rig.report.servo_limit);
}

}  // namespace
}  // namespace ninedot
