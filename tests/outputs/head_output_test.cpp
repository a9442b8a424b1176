// The whole loop: a rendered picture as the turned camera sees it -> pose -> aiming step -> simulated head -> next
// picture.
#include "outputs/head_output.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <numbers>
#include <thread>

#include "drivers/servo/simulated_pan_tilt.h"
#include "outputs/output_thread.h"
#include "pipeline/localiser.h"
#include "pipeline/next_report.h"
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
  explicit Rig(const AimOrder& order = {}, double distance_m = 2, double tilt_rad = 10 * kDeg,
               const LocaliserOptions& options = {})
      : head(axes(), {}),
        output(CameraModel{}, aim_options(), head, &inhibit, order),
        localiser_(CameraModel{}, options) {
    straight_ = test::look_at_landmark(
        {.distance_m = distance_m, .tilt_rad = tilt_rad, .off_axis_x_rad = -15 * kDeg, .off_axis_y_rad = 10 * kDeg});
  }

  void one_frame() {
    const HeadAngles at = head.state().angles;
    test::Scene scene;
    scene.camera = turned(at);
    const test::Picture picture = test::render(scene, 7);
    Frame frame;
    frame.luma = picture.view();
    frame.number = frame_++;
    frame.set_exposure(now_);
    report = next_report(report, frame, localiser_.process(frame), {now_ + 10ms, &output.snapshots().take()});
    output.take(report, true, now_ + 10ms);
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
  HeadOutput output;
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

TEST(HeadOutput, BringsTheLandmarkToTheMiddleOfThePictureAndKeepsItThere) {
  Rig rig;
  EXPECT_GT(rig.off_axis_rad(), 15 * kDeg);
  for (int i = 0; i < 40; ++i) rig.one_frame();
  for (int i = 0; i < 5; ++i) {
    rig.one_frame();
    EXPECT_TRUE(rig.report.valid);
    // The dead band of each axis, and half a pixel from the optical axis to the middle of the picture.
    EXPECT_LT(rig.off_axis_rad(), 0.35 * kDeg);
  }
  EXPECT_TRUE(rig.report.head.present);
  EXPECT_GT(rig.report.head.pan_rad, 10 * kDeg) << "the landmark was on the left";
  EXPECT_LT(rig.report.head.tilt_rad, -5 * kDeg) << "and below the middle";
  EXPECT_FALSE(rig.report.head.limited || rig.report.head.failed || rig.report.head.inhibited);
}

TEST(HeadOutput, StopsWithinOneFrameOfTheInhibitInput) {
  Rig rig;
  for (int i = 0; i < 3; ++i) rig.one_frame();
  rig.inhibit.active = true;
  const HeadAngles before = rig.head.state().angles;
  for (int i = 0; i < 3; ++i) rig.one_frame();
  EXPECT_EQ(rig.head.state().angles.pan_rad, before.pan_rad);
  EXPECT_TRUE(rig.report.head.inhibited);
  EXPECT_EQ(rig.head.stops, 1) << "said once, not with every frame";
  rig.inhibit.active = false;
  for (int i = 0; i < 40; ++i) rig.one_frame();
  EXPECT_LT(rig.off_axis_rad(), 0.35 * kDeg);
}

TEST(HeadOutput, GoesToASetPointAndSaysWhenItLiesBeyondTheLimits) {
  Rig rig({false, {}});
  rig.one_frame();
  EXPECT_EQ(rig.head.state().angles.pan_rad, 0);
  rig.output.order({false, {-70 * kDeg, 5 * kDeg}, 1});
  for (int i = 0; i < 60; ++i) rig.output.take(rig.report, false, MonoTime(2s) + i * kFrame);
  EXPECT_NEAR(rig.head.state().angles.pan_rad, -50 * kDeg, 1e-9);
  EXPECT_NEAR(rig.head.state().angles.tilt_rad, 5 * kDeg, 1e-9);
  const HeadSnapshot snapshot = rig.output.snapshots().take();
  EXPECT_TRUE(snapshot.limited);
  EXPECT_EQ(snapshot.order, 1U);
}

TEST(HeadOutput, GoesOnBetweenFramesButTakesNoReportForANewOne) {
  Rig rig;
  rig.one_frame();
  rig.one_frame();
  ASSERT_TRUE(rig.report.valid);
  const double before_rad = rig.off_axis_rad();
  for (int i = 0; i < 5; ++i) rig.output.take(rig.report, false, MonoTime(1070ms) + i * HeadOutput::kPeriod);
  EXPECT_LT(rig.off_axis_rad(), before_rad - 2 * kDeg);
  for (int i = 0; i < 60; ++i) rig.output.take(rig.report, false, MonoTime(1120ms) + i * HeadOutput::kPeriod);
  EXPECT_EQ(rig.output.snapshots().take().state, AimState::kCoast) << "without a frame it is out of sight";
}

/// Far away and seen from in front both mirror images fit: no pose may be acted on, but both hang in one place.
TEST(HeadOutput, TurnsToALandmarkWhosePoseIsAmbiguous) {
  LocaliserOptions cautious;
  cautious.trust.max_ambiguity = 1e-6;
  Rig rig({}, 6, 3 * kDeg, cautious);
  int ambiguous = 0;
  for (int i = 0; i < 40; ++i) {
    rig.one_frame();
    if (!rig.report.ambiguous) continue;
    ++ambiguous;
    EXPECT_FALSE(rig.report.valid);
    EXPECT_EQ(rig.report.sights.size(), 1U) << i;
  }
  EXPECT_GT(ambiguous, 10) << "else this shows nothing";
  EXPECT_LT(rig.off_axis_rad(), 0.5 * kDeg);
  EXPECT_EQ(rig.output.snapshots().take().state, AimState::kTrack);
}

TEST(HeadOutput, ParksAndSaysWhenItIsThere) {
  AimOptions options = aim_options();
  options.park = {-20 * kDeg, 10 * kDeg};
  SimulatedPanTilt head(axes(), {});
  HeadOutput output(CameraModel{}, options, head, nullptr, {});
  output.order({true, {}, 5, true});
  HeadSnapshot snapshot;
  for (int i = 0; i < 200 && snapshot.progress != OrderProgress::kDone; ++i) {
    output.take(Report{}, false, MonoTime(1s) + i * HeadOutput::kPeriod);
    snapshot = output.snapshots().take();
    if (i < 20) {
      EXPECT_EQ(snapshot.progress, OrderProgress::kRunning) << "sent, and not there yet";
    }
  }
  EXPECT_EQ(snapshot.progress, OrderProgress::kDone);
  EXPECT_EQ(snapshot.state, AimState::kPark);
  EXPECT_NEAR(head.state().angles.pan_rad, -20 * kDeg, 1e-9);
}

/// Beside the landmark that is reported, the head knows the others of the frame.
TEST(HeadOutput, FollowsTheLandmarkThatItIsToldToThoughAnotherIsReported) {
  AimOptions options = aim_options();
  options.landmark = LandmarkChoice::kById;
  options.landmark_id = 7;
  SimulatedPanTilt head(axes(), {});
  HeadOutput output(CameraModel{}, options, head, nullptr, {});
  Report report;
  report.valid = true;
  report.landmark_id = 3;
  report.camera_in_landmark.position_m = {0, -2, 0};
  ASSERT_TRUE(report.sights.try_push_back({3, MonoTime(1s), {0, 0, 2}}));
  ASSERT_TRUE(report.sights.try_push_back({7, MonoTime(1s), {-0.4, 0, 2}}));
  report.exposed_at = MonoTime(1s);
  output.take(report, true, MonoTime(1020ms));
  EXPECT_EQ(output.snapshots().take().state, AimState::kAcquire);
  for (int i = 1; i < 8; ++i) output.take(report, false, MonoTime(1020ms) + i * HeadOutput::kPeriod);
  EXPECT_GT(head.state().angles.pan_rad, 2 * kDeg) << "to the left, where 7 is";
}

/// Takes its time, as a slow bus does, and remembers when it was told what.
class SlowHead final : public PanTilt {
 public:
  void move_to(const HeadAngles& angles) noexcept override {
    std::this_thread::sleep_for(30ms);
    told_rad.store(angles.pan_rad);
    ++moves;
  }
  void stop() noexcept override {}
  HeadState state() const noexcept override {
    HeadState state;
    state.angles.pan_rad = told_rad;
    return state;
  }
  std::atomic<double> told_rad{0};
  std::atomic<int> moves{0};
};

class OrdinaryThread final : public FrameThread {
 public:
  Result<void> enter() noexcept override { return fail(Errc::kIo, "refused", EPERM); }
};

TEST(HeadOutput, InAThreadOfItsOwnASlowHeadDelaysNoReportAndOrdersArriveWithoutFrames) {
  SlowHead head;
  HeadOutput output(CameraModel{}, aim_options(), head, nullptr, {});
  Mailbox<Report> reports;
  OrdinaryThread priority;
  const OutputThread thread(reports, output, priority, 5ms);
  ASSERT_FALSE(thread.realtime());
  EXPECT_EQ(thread.realtime().error().os_errno, EPERM);
  constexpr int kReports = 50;
  std::chrono::nanoseconds in_all{};
  for (int i = 0; i < kReports; ++i) {
    const MonoTime begin = mono_now();
    reports.publish(Report{});
    (void)output.snapshots().take();
    in_all += mono_now() - begin;
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_LT(in_all, kReports * 30ms / 2) << "far from a move of this head for each report";
  output.order({false, {0.05, 0}, 3});
  const MonoTime begin = mono_now();
  while (output.snapshots().take().progress != OrderProgress::kDone && mono_now() < begin + 5s)
    std::this_thread::sleep_for(1ms);
  EXPECT_EQ(head.told_rad, 0.05);
  EXPECT_EQ(output.snapshots().take().order, 3U);
}

}  // namespace
}  // namespace ninedot
