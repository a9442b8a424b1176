#include "drivers/simulation/simulated_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/units.h"
#include "geometry/body.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// A robot that drives past the landmark along x, 1.5 m before it, looking at the wall.
SimulationOptions passing() {
  SimulationOptions options;
  HungSheet sheet;
  sheet.inks.fill({0.04F, 0.04F, 0.04F});
  options.sheets = {sheet};
  options.robot = {{0, {-1, 1.5, 0}, -90 * kRadPerDeg}, {2, {1, 1.5, 0}, -90 * kRadPerDeg}};
  options.rate_hz = 50;
  options.duration_s = 2;
  options.camera_delay = 30ms;
  return options;
}

class Loop {
 public:
  explicit Loop(const SimulationOptions& options)
      : camera(options, line, clock), head(line, clock, options.start), began_at(clock.now()) {}
  double now_s() const { return std::chrono::duration<double>(clock.now() - began_at).count(); }

  VirtualClock clock;
  std::shared_ptr<HeadLine> line = std::make_shared<HeadLine>();
  SimulatedCamera camera;
  SimulatedHead head;
  MonoTime began_at;
};

TEST(SimulatedCamera, GivesEachFrameAtItsTimeAndEndsWithTheScenario) {
  Loop loop(passing());
  int frames = 0;
  for (;; ++frames) {
    const Result<FrameLease> lease = loop.camera.next(MonoTime::max());
    if (!lease) {
      EXPECT_EQ(lease.error().code, Errc::kEndOfStream);
      break;
    }
    EXPECT_EQ(lease->frame.number, static_cast<std::uint64_t>(frames));
    EXPECT_EQ(lease->frame.exposed_at(), loop.began_at + frames * 20ms);
    EXPECT_EQ(loop.clock.now(), lease->frame.exposed_at() + 30ms);
    EXPECT_EQ(lease->dropped_before, 0U);
    const SimulationTruth& truth = loop.camera.truth();
    EXPECT_DOUBLE_EQ(truth.t_s, frames * 0.02);
    EXPECT_NEAR(truth.body.position_m.x(), -1 + truth.t_s, 1e-9);
  }
  EXPECT_EQ(frames, 100);
}

TEST(SimulatedCamera, SaysNoFrameWhenTheDeadlineComesFirst) {
  Loop loop(passing());
  const MonoTime deadline = loop.clock.now() + 10ms;
  const Result<FrameLease> lease = loop.camera.next(deadline);
  ASSERT_FALSE(lease);
  EXPECT_EQ(lease.error().code, Errc::kNoFrame);
  EXPECT_EQ(loop.clock.now(), deadline);
}

TEST(SimulatedCamera, LosesAndCountsTheFramesThatNobodyFetched) {
  Loop loop(passing());
  loop.camera.next(MonoTime::max());
  loop.clock.sleep_until(loop.clock.now() + 105ms);  // frames 1 to 5 have arrived
  const Result<FrameLease> lease = loop.camera.next(MonoTime::max());
  ASSERT_TRUE(lease);
  EXPECT_EQ(lease->frame.number, 5U);
  EXPECT_EQ(lease->dropped_before, 4U);
  EXPECT_EQ(loop.clock.now() - lease->frame.exposed_at(), 35ms) << "late, and says so";
}

TEST(SimulatedCamera, StartsAgainWhereItLoops) {
  SimulationOptions options = passing();
  options.loop = true;
  Loop loop(options);
  for (int i = 0; i < 103; ++i) ASSERT_TRUE(loop.camera.next(MonoTime::max()));
  EXPECT_NEAR(loop.camera.truth().t_s, 0.04, 1e-9);
  EXPECT_NEAR(loop.camera.truth().body.position_m.x(), -0.96, 1e-9);
}

TEST(SimulatedCamera, TurnsItsHeadAsItIsTold) {
  SimulationOptions options = passing();
  options.pan.speed_rad_s = 1;
  options.pan.acceleration_rad_s2 = 1e3;
  options.pan.delay = 100ms;
  options.tilt.speed_rad_s = 1e-9;
  Loop loop(options);
  loop.camera.next(MonoTime::max());
  loop.head.move_to({0.5, 0.2});  // at 30 ms
  while (loop.camera.truth().t_s < 0.4) ASSERT_TRUE(loop.camera.next(MonoTime::max()));
  EXPECT_NEAR(loop.camera.truth().head.pan_rad, 0.4 - 0.13, 2e-3);
  EXPECT_NEAR(loop.camera.truth().head.tilt_rad, 0, 1e-6);
  EXPECT_EQ(loop.head.state().angles.pan_rad, 0.5) << "as it was told";
  while (loop.camera.truth().t_s < 0.7) ASSERT_TRUE(loop.camera.next(MonoTime::max()));
  EXPECT_NEAR(loop.camera.truth().head.pan_rad, 0.5, 1e-9);
}

TEST(SimulatedCamera, HearsNoCommandBeforeItWasGiven) {
  // Frame 1 is exposed at 20 ms, when frame 0, which arrives at 30 ms, has moved nothing yet.
  SimulationOptions options = passing();
  options.pan.speed_rad_s = 100, options.pan.acceleration_rad_s2 = 1e4;
  Loop loop(options);
  loop.camera.next(MonoTime::max());
  loop.head.move_to({0.5, 0});
  loop.camera.next(MonoTime::max());
  EXPECT_EQ(loop.camera.truth().head.pan_rad, 0);
  loop.camera.next(MonoTime::max());
  EXPECT_GT(loop.camera.truth().head.pan_rad, 0.2);
}

TEST(SimulatedCamera, SaysTheTruthOfTheMainLandmark) {
  Loop loop(passing());
  loop.camera.next(MonoTime::max());
  const SimulationTruth& truth = loop.camera.truth();
  EXPECT_NEAR(truth.centre_error_rad, std::atan2(1, 1.5), 1e-12);
  EXPECT_FALSE(truth.visible) << "33.7 deg aside; the picture ends at 23.9";
  while (truth.t_s < 0.999) ASSERT_TRUE(loop.camera.next(MonoTime::max()));
  EXPECT_NEAR(truth.centre_error_rad, 0, 1e-9);
  EXPECT_TRUE(truth.visible);
}

TEST(SimulatedCamera, IsCoveredWhileTheScenarioSaysSo) {
  SimulationOptions options = passing();
  options.renderer.noise_lsb = 0;
  options.hidden = {{0.9, 1.1}};
  Loop loop(options);
  int hidden = 0, seen = 0;
  while (const Result<FrameLease> lease = loop.camera.next(MonoTime::max())) {
    const double t_s = loop.camera.truth().t_s;
    if (std::abs(t_s - 1) > 0.25) continue;
    const ImageView& luma = lease->frame.luma;
    const bool is_covered = luma.at(10, 10) < 100;  // the wall has 149
    EXPECT_EQ(is_covered, t_s > 0.8999 && t_s < 1.0999) << t_s;
    EXPECT_EQ(is_covered, !loop.camera.truth().visible) << t_s;
    ++(is_covered ? hidden : seen);
  }
  EXPECT_EQ(hidden, 10);
  EXPECT_GT(seen, 10);
}

TEST(SimulatedCamera, SitsOnTheBodyWhereTheEstimatorTakesItToSit) {
  test::Random random(3);
  const auto some = [&](double reach) {
    return Eigen::Vector3d(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
  };
  for (int i = 0; i < 50; ++i) {
    const HeadMount mount{some(0.5), some(1), some(0.1), some(0.1), some(0.3)};
    const BodyGeometry body{mount.pan_axis_m, mount.mount_rpy_rad, mount.tilt_axis_m, mount.camera_m,
                            mount.camera_rpy_rad};
    const HeadAngles head{random.uniform(-1, 1), random.uniform(-1, 1)};
    const Eigen::Isometry3d T = world_from_camera({}, mount, head);
    const BodyFromCamera expected = camera_on_body(body, head).T_body_camera;
    EXPECT_LT((T.linear() - expected.rotation).norm(), 1e-12);
    EXPECT_LT((T.translation() - expected.translation_m).norm(), 1e-12);
  }
}

TEST(RobotPath, IsStraightBetweenItsPointsAndStandsBeforeAndAfter) {
  const std::vector<WayPoint> path{{1, {0, 0, 0}, 0}, {3, {2, 4, 6}, 1}, {4, {2, 4, 6}, -1}};
  EXPECT_EQ(place_on(path, 0).position_m.norm(), 0);
  EXPECT_NEAR(place_on(path, 1.5).position_m.y(), 1, 1e-12);
  EXPECT_NEAR(place_on(path, 1.5).heading_rad, 0.25, 1e-12);
  EXPECT_NEAR(place_on(path, 3.5).heading_rad, 0, 1e-12);
  EXPECT_NEAR(place_on(path, 9).heading_rad, -1, 1e-12);
}

TEST(SimulatedCamera, AllocatesNothingPerFrame) {
  Loop loop(passing());
  const test::AllocationGuard guard;
  for (int i = 0; i < 20; ++i) {
    loop.head.move_to({0.01 * i, 0});
    const Result<FrameLease> lease = loop.camera.next(MonoTime::max());
  }
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace ninedot
