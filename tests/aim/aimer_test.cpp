#include "aim/aimer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Eigen::AngleAxisd;
using Eigen::Vector3d;
using enum AimState;

constexpr double kDeg = std::numbers::pi / 180;
constexpr MonoTime kStart{100s};
constexpr auto kFrame = 20ms;

/// Camera to the camera of a head that stands at 0, 0: pan about "up" (-y), then tilt about "right" (x).
Eigen::Matrix3d turned(const HeadAngles& head) {
  return (AngleAxisd(head.pan_rad, -Vector3d::UnitY()) * AngleAxisd(head.tilt_rad, Vector3d::UnitX()))
      .toRotationMatrix();
}

AimOptions wide() {
  AimOptions options;
  options.pan = {-3, 3, 1, 1000};
  options.tilt = {-1.4, 1.4, 1, 1000};
  options.gain = 1;
  options.search = false;
  return options;
}

/// Frames every 20 ms of a head that stands at once where it is told, and of a landmark at known head angles.
class Bench {
 public:
  explicit Bench(const AimOptions& options = wide(), const HeadAngles& at = {}) : unit(CameraModel{}, options, at) {
    head.angles = at;
  }
  AimStep step(const AimOrder& order = {}, bool inhibited = false) {
    now += kFrame;
    std::vector<AimSight> sights;
    if (landmark)
      sights.push_back({1, now, 2 * (turned(head.angles).transpose() * turned(*landmark) * Vector3d::UnitZ())});
    const AimStep step = unit.step(now, head, {true, sights}, order, inhibited);
    if (!head.absent && !inhibited) head.angles = step.command;
    return step;
  }
  AimStep steps(int count, const AimOrder& order = {}) {
    AimStep last;
    for (int i = 0; i < count; ++i) last = step(order);
    return last;
  }
  Aimer unit;
  HeadState head;
  std::optional<HeadAngles> landmark;
  MonoTime now = kStart;
};

TEST(Aimer, TurnsToTheLandmarkNoFasterThanTheAxisMayAndStopsThere) {
  Bench bench;
  bench.landmark = {0.35, -0.25};
  for (int i = 0; i < 100; ++i) {
    const HeadAngles before = bench.head.angles;
    const AimStep step = bench.step();
    EXPECT_LE(std::abs(step.command.pan_rad - before.pan_rad), 0.02 + 1e-12);
    EXPECT_LE(std::abs(step.command.tilt_rad - before.tilt_rad), 0.02 + 1e-12);
  }
  EXPECT_EQ(bench.unit.state(), kTrack);
  // The middle of the picture is half a pixel from the optical axis of the default camera.
  EXPECT_NEAR(bench.head.angles.pan_rad, 0.35, 1e-3);
  EXPECT_NEAR(bench.head.angles.tilt_rad, -0.25, 1e-3);
}

TEST(Aimer, RampsFromWhereTheHeadStandsToNeutralAndNeverJumpsThere) {
  AimOptions options = wide();
  options.neutral = {0.5, -0.1};
  options.pan.acceleration_rad_per_s2 = 5;
  Bench bench(options, {-0.4, 0.3});
  double rate = 0;
  for (int i = 0; i < 100; ++i) {
    const HeadAngles before = bench.head.angles;
    const AimStep step = bench.step();
    const double now_rate = (step.command.pan_rad - before.pan_rad) / 0.02;
    EXPECT_LE(std::abs(now_rate), 1 + 1e-9);
    EXPECT_LE(std::abs(now_rate - rate), 5 * 0.02 + 1e-9);
    rate = now_rate;
  }
  EXPECT_EQ(bench.head.angles, options.neutral);
}

TEST(Aimer, StaysWithinTheDeadBand) {
  AimOptions options = wide();
  options.dead_band_rad = 1 * kDeg;
  Bench bench(options);
  bench.landmark = {0.2, 0};
  bench.steps(60);
  const HeadAngles there = bench.head.angles;
  bench.landmark = {0.2 + 0.8 * kDeg, 0};
  bench.steps(60);
  EXPECT_EQ(bench.head.angles, there);
  bench.landmark = {0.2 + 1.3 * kDeg, 0};
  bench.steps(60);
  EXPECT_NEAR(bench.head.angles.pan_rad, 0.2 + 1.3 * kDeg, 0.3 * kDeg);
}

TEST(Aimer, StaysWithoutALandmarkAndWithoutASearch) {
  Bench bench;
  bench.steps(200);
  EXPECT_EQ(bench.head.angles, HeadAngles{});
  EXPECT_EQ(bench.unit.state(), kHold);
}

TEST(Aimer, SaturatesAtTheLimitsAndSaysSo) {
  AimOptions options = wide();
  options.pan = {-0.1, 0.1, 1, 1000};
  Bench bench(options);
  const AimStep step = bench.steps(20, {false, {0.4, 0.05}});
  EXPECT_TRUE(step.limited && step.at_goal);
  EXPECT_EQ(bench.head.angles, (HeadAngles{0.1, 0.05}));
  EXPECT_FALSE(bench.step({false, {0.05, 0.05}}).limited);
  bench.landmark = {0.3, 0};
  EXPECT_TRUE(bench.steps(20).limited);
  EXPECT_NEAR(bench.head.angles.pan_rad, 0.1, 1e-9);
}

TEST(Aimer, GoesExactlyToASetPointWhateverTheDeadBandAndTheGain) {
  AimOptions options = wide();
  options.dead_band_rad = 0.1;
  options.gain = 0.2;
  Bench bench(options);
  EXPECT_TRUE(bench.steps(20, {false, {0.05, -0.03}}).at_goal);
  EXPECT_EQ(bench.head.angles, (HeadAngles{0.05, -0.03}));
  EXPECT_EQ(bench.unit.state(), kHold);
}

/// What a late frame shows is of where the head stood then, between two of its stamps.
TEST(Aimer, ReckonsFromWhereTheHeadStoodWhenTheFrameWasExposed) {
  for (const auto head_delay : {0ms, 60ms}) {
    AimOptions options = wide();
    options.head_delay = head_delay;
    Aimer unit(CameraModel{}, options);
    HeadState head;
    for (int i = 0; i < 10; ++i) {
      head.angles.pan_rad = 0.01 * i;
      unit.step(kStart + i * kFrame, head, {}, {false, {1, 0}}, false);
    }
    EXPECT_NEAR(unit.track().at(kStart + head_delay + 4 * kFrame + 5ms).pan_rad, 0.0425, 1e-12);
    // Straight ahead of where it stood then.
    const AimSight sight{1, kStart + head_delay + 4 * kFrame + 5ms, {0, 0, 2}};
    unit.step(kStart + 10 * kFrame, head, {true, {&sight, 1}}, {false, {1, 0}}, false);
    const AimSight again{1, sight.exposed_at + 20ms, turned({-0.01, 0}) * Vector3d(0, 0, 2)};
    unit.step(kStart + 11 * kFrame, head, {true, {&again, 1}}, {}, false);
    HeadAngles command;
    for (int i = 12; i < 24; ++i) command = unit.step(kStart + i * kFrame, head, {}, {}, false).command;
    EXPECT_NEAR(command.pan_rad, 0.0425, 1e-3) << "though the head stood at 0.09 when the frames came";
  }
}

TEST(Aimer, AHeadThatSaysWhereItStandsIsBelievedWithoutDelay) {
  AimOptions options = wide();
  options.head_delay = 100ms;
  Aimer unit(CameraModel{}, options);
  HeadState head;
  head.measured = true;
  head.angles.pan_rad = 0.3;
  unit.step(kStart, head, {}, {}, false);
  EXPECT_EQ(unit.track().at(kStart).pan_rad, 0.3);
}

TEST(Aimer, DoesNotMoveWhileInhibitedAndGoesOnFromWhereTheHeadStands) {
  Bench bench(wide(), {0.3, 0.1});
  for (int i = 0; i < 5; ++i) {
    const AimStep step = bench.step({false, {1, 1}}, true);
    EXPECT_EQ(step.command, (HeadAngles{0.3, 0.1}));
    EXPECT_EQ(step.state, kHold);
    EXPECT_FALSE(step.at_goal);
  }
  EXPECT_NEAR(bench.step({false, {1, 1}}).command.pan_rad, 0.32, 1e-3);
}

TEST(Aimer, AHeadThatComesBackSetsOutFromWhereItIs) {
  Bench bench;
  bench.steps(100, {false, {0.8, 0}});
  bench.head.absent = true;
  for (int i = 0; i < 100; ++i) bench.step({false, {-0.8, 0}});
  bench.head.absent = false;
  bench.head.angles = {0.1, 0};  // opened anew, elsewhere
  bench.head.absent = true;
  bench.step({false, {-0.8, 0}});
  bench.head.absent = false;
  EXPECT_NEAR(bench.step({false, {-0.8, 0}}).command.pan_rad, 0.08, 1e-3);
}

TEST(Aimer, MakesNoJumpAfterALongPause) {
  Bench bench;
  bench.step({false, {2, 0}});
  bench.now += 60s;
  EXPECT_LE(bench.step({false, {2, 0}}).command.pan_rad, 0.1 + 1e-12);
}

AimOptions searching() {
  AimOptions options = wide();
  options.search = true;
  options.coast = 500ms;
  options.pan = {-1, 1, 1, 20};
  options.tilt = {-0.3, 0.3, 1, 20};
  return options;
}

TEST(Aimer, GoesThroughItsStatesAsALandmarkComesAndGoes) {
  Bench bench(searching());
  EXPECT_EQ(bench.steps(100).state, kHold) << "nothing has been seen yet: no search";
  bench.landmark = {0.3, 0};
  EXPECT_EQ(bench.step().state, kAcquire);
  EXPECT_EQ(bench.steps(60).state, kTrack);
  bench.landmark = {0.3 - 12 * kDeg, 0};
  EXPECT_EQ(bench.step().state, kAcquire);
  EXPECT_EQ(bench.steps(60).state, kTrack);
  bench.landmark.reset();
  EXPECT_EQ(bench.step().state, kCoast);
  EXPECT_EQ(bench.steps(20).state, kCoast);
  EXPECT_EQ(bench.steps(10).state, kSearch);
  bench.landmark = bench.head.angles;
  EXPECT_EQ(bench.step().state, kAcquire) << "stops at the first sight";
  EXPECT_EQ(bench.step().state, kTrack);
}

TEST(Aimer, SearchesFromTheStartOnlyIfItMayAndHoldsAfterALossIfItMayNotSearch) {
  AimOptions options = searching();
  options.search_at_start = true;
  Bench eager(options);
  EXPECT_EQ(eager.steps(2).state, kSearch);
  options.search = false;
  Bench calm(options);
  calm.landmark = {0.1, 0};
  calm.steps(60);
  calm.landmark.reset();
  calm.steps(60);
  const HeadAngles there = calm.head.angles;
  EXPECT_EQ(calm.steps(200).state, kHold);
  EXPECT_EQ(calm.head.angles, there);
}

TEST(Aimer, ParksWhenToldAndAfterALongIdleTimeAndIsWokenByASightInTheLatterCaseOnly) {
  AimOptions options = searching();
  options.park = {-0.5, 0.2};
  options.park_after = 2s;
  Bench bench(options);
  bench.landmark = {0.1, 0};
  const AimOrder park{true, {}, 3, true};
  EXPECT_EQ(bench.step(park).state, kPark);
  EXPECT_TRUE(bench.steps(80, park).at_goal);
  EXPECT_EQ(bench.head.angles, options.park);
  EXPECT_EQ(bench.unit.state(), kPark) << "the landmark in sight changes nothing";
  EXPECT_NE(bench.steps(3, {true, {}, 4}).state, kPark);
  bench.steps(100, {true, {}, 4});
  bench.landmark.reset();
  EXPECT_EQ(bench.steps(95, {true, {}, 4}).state, kSearch);
  EXPECT_EQ(bench.steps(100, {true, {}, 4}).state, kPark);
  EXPECT_EQ(bench.head.angles, options.park);
  bench.landmark = {-0.4, 0.1};
  EXPECT_EQ(bench.step({true, {}, 4}).state, kAcquire);
}

TEST(Aimer, AllocatesNothingWhateverItDoes) {
  AimOptions options = searching();
  options.park_after = 20s;
  Aimer unit(CameraModel{}, options);
  HeadState head;
  std::uint64_t states = 0;
  const test::AllocationGuard guard;
  for (int i = 0; i < 4000; ++i) {
    const MonoTime now = kStart + i * kFrame;
    const std::array<AimSight, 2> sights{
        {{1, now, {i < 250 ? 0.3 : 0.0, 0.01, 2}}, {2, now, {-0.02, 0, 1 + 0.001 * i}}}};
    const bool sees = i > 100 && i < 400;
    const AimOrder order{i<3000, {0.2, 0.1}, 1, i> 3500};
    const AimStep step = unit.step(now, head, {true, std::span(sights).first(sees ? 2 : 0)}, order, i > 3900);
    head.angles = step.command;
    states |= std::uint64_t{1} << static_cast<unsigned>(step.state);
  }
  EXPECT_EQ(guard.allocations() + guard.releases(), 0U);
  EXPECT_EQ(states, 0b1111110U) << "it went through all of its states";
}

TEST(Aimer, WithoutAnyFrameTheLandmarkCountsAsMissedAfterAWhile) {
  Bench bench;
  bench.landmark = {0.1, 0};
  bench.steps(60);
  for (int i = 0; i < 14; ++i) EXPECT_EQ(bench.unit.step(bench.now += 20ms, bench.head, {}, {}, false).state, kTrack);
  for (int i = 0; i < 4; ++i) bench.unit.step(bench.now += 20ms, bench.head, {}, {}, false);
  EXPECT_EQ(bench.unit.state(), kCoast);
}

}  // namespace
}  // namespace ninedot
