// When the track begins, what it refuses, and when it begins anew.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "tests/track/room.h"

namespace ninedot {
namespace {

using test::Way;

MonoTime instant(double t_s) { return mono_from_ns(1'000'000'000 + std::llround(t_s * 1e9)); }

constexpr double kFrame_s = 1 / test::kRate_hz;

/// Watches a way, frame by frame.
class Watch {
 public:
  Watch(const LandmarkMap& map, Way way, std::uint64_t seed = 1)
      : filter(PoseFilterOptions{}), map_(map), way_(std::move(way)), camera_(map, {}, seed) {}

  FilterVerdict look() { return look_from(way_(time_s() + kFrame_s)); }
  FilterVerdict look_from(const WorldFromCamera& truth) {
    ++frame_;
    const auto seen = camera_.see(truth, kFrame_s);
    return filter.take(instant(time_s()), test::members_of(seen, map_), test::readings_of(seen, map_, truth));
  }
  void look_for(int frames) {
    for (int i = 0; i < frames; ++i) look();
  }
  double time_s() const { return frame_ * kFrame_s; }
  TrackedPose tracked() const { return filter.at(instant(time_s())).value(); }
  double error_m() const {
    return (tracked().motion.T_world_camera.translation_m - way_(time_s()).translation_m).norm();
  }

  PoseFilter filter;

 private:
  const LandmarkMap& map_;
  Way way_;
  test::Camera camera_;
  int frame_ = 0;
};

/// Sees four landmarks.
WorldFromCamera middle_of_the_room() { return test::camera_at({0, -0.2, 1.0}, 0.2, 0.09, 0); }
Way standing() {
  return [](double) { return middle_of_the_room(); };
}

TEST(PoseFilterRules, ATrackBeginsWithTheFirstFrameThatShowsWhereItIs) {
  const LandmarkMap map = test::room_map();
  PoseFilter filter({});
  EXPECT_FALSE(filter.at(instant(0)).has_value());
  EXPECT_FALSE(filter.forecast(instant(0)).has_value());
  test::Camera camera(map, {}, 1);
  const auto seen = camera.see(middle_of_the_room(), kFrame_s);
  const auto readings = test::readings_of(seen, map, middle_of_the_room());
  EXPECT_EQ(filter.take(instant(0), {}, readings), FilterVerdict::kNothing) << "no sighting";
  EXPECT_EQ(filter.take(instant(0.1), test::members_of(seen, map), {}), FilterVerdict::kNothing) << "no reading";
  EXPECT_EQ(filter.take(instant(0.3), test::members_of(seen, map), readings), FilterVerdict::kStarted);
  ASSERT_TRUE(filter.at(instant(0.3)).has_value());
  EXPECT_FALSE(filter.at(instant(0.2)).has_value()) << "before it";
}

TEST(PoseFilterRules, FramesThatAreNotNewerAreRefusedAndChangeNothing) {
  const LandmarkMap map = test::room_map();
  Watch watch(map, standing());
  watch.look_for(10);
  const TrackedPose before = watch.tracked();
  test::Camera camera(map, {}, 5);
  const auto seen = camera.see(middle_of_the_room(), kFrame_s);
  const auto readings = test::readings_of(seen, map, middle_of_the_room());
  EXPECT_EQ(watch.filter.take(instant(watch.time_s()), test::members_of(seen, map), readings), FilterVerdict::kTooLate);
  EXPECT_EQ(watch.filter.take(instant(watch.time_s() - 0.01), test::members_of(seen, map), readings),
            FilterVerdict::kTooLate);
  EXPECT_EQ(watch.tracked().covariance, before.covariance);
  EXPECT_EQ(watch.tracked().motion.T_world_camera.translation_m, before.motion.T_world_camera.translation_m);
}

TEST(PoseFilterRules, AJumpPutsTheTrackInDoubtAtOnceAndAfterFiveFramesItBeginsAnew) {
  const LandmarkMap map = test::room_map();
  const WorldFromCamera elsewhere = test::camera_at({0.6, 0.4, 1.1}, 0.2, 0.09, 0);
  Watch watch(map, [&](double t) { return t < 1 ? middle_of_the_room() : elsewhere; });
  while (watch.time_s() + kFrame_s < 1) watch.look();
  EXPECT_EQ(watch.tracked().gated_frames, 0);
  for (int gated = 1; gated < PoseFilter::kMaxGated; ++gated) {
    EXPECT_EQ(watch.look(), FilterVerdict::kGated);
    EXPECT_EQ(watch.tracked().gated_frames, gated);
  }
  EXPECT_EQ(watch.look(), FilterVerdict::kStarted);
  EXPECT_EQ(watch.tracked().gated_frames, 0);
  watch.look_for(10);
  EXPECT_LT(watch.error_m(), 0.01);
}

TEST(PoseFilterRules, OneFrameThatIsElsewhereLeavesTheTrackWhereItWas) {
  const LandmarkMap map = test::room_map();
  Watch watch(map, standing());
  watch.look_for(20);
  EXPECT_EQ(watch.look_from(test::camera_at({0.6, 0.4, 1.1}, 0.2, 0.09, 0)), FilterVerdict::kGated);
  EXPECT_LT(watch.error_m(), 0.01);
  EXPECT_EQ(watch.look(), FilterVerdict::kTaken);
  EXPECT_LT(watch.error_m(), 0.01);
}

TEST(PoseFilterRules, ASecondWithoutSightEndsTheTrack) {
  const LandmarkMap map = test::room_map();
  Watch watch(map, standing());
  watch.look_for(20);
  const double last_s = watch.time_s();
  EXPECT_TRUE(watch.filter.at(instant(last_s + 0.99)).has_value());
  EXPECT_FALSE(watch.filter.at(instant(last_s + 1.01)).has_value());
  test::Camera camera(map, {}, 5);
  const auto seen = camera.see(middle_of_the_room(), kFrame_s);
  EXPECT_EQ(watch.filter.take(instant(last_s + 1.1), test::members_of(seen, map),
                              test::readings_of(seen, map, middle_of_the_room())),
            FilterVerdict::kStarted);
}

TEST(PoseFilterRules, AForecastMovesOnAndKnowsLess) {
  const LandmarkMap map = test::room_map();
  Watch watch(map, test::walk(0.3));
  watch.look_for(35);
  const auto now = watch.filter.forecast(instant(watch.time_s())),
             next = watch.filter.forecast(instant(watch.time_s() + kFrame_s));
  ASSERT_TRUE(now && next);
  const Eigen::Vector3d moved_m = next->T_world_camera.translation_m - now->T_world_camera.translation_m;
  EXPECT_NEAR(moved_m.norm(), 1.0 * kFrame_s, 0.15 * kFrame_s) << "1 m/s";
  for (int i = 0; i < 6; ++i) EXPECT_GT(next->covariance(i, i), now->covariance(i, i)) << i;
}

/// The sheet turned in its plane by one eighth, as a place: its Pk hangs where P(k + 1) was.
WorldFromLandmark turned(const WorldFromLandmark& place) {
  return {place.rotation * exp_so3({0, -std::numbers::pi / 4, 0}), place.translation_m};
}

TEST(PoseFilterRules, TwoNumberingsAreFollowedWithTheirOddsUntilAFrameTellsThemApart) {
  const LandmarkMap wall = test::wall_map();
  const WorldFromLandmark& place = wall.landmarks()[0].T_world_landmark;
  const WorldFromCamera truth = test::camera_at({1.5, 0.9, 1.4}, -0.35, 0, 0);
  // Where the camera would be if what the sighting calls P(k + 1) were the sheet's Pk.
  const WorldFromCamera rival = place * (turned(place).inverse() * truth);
  PoseFilter filter({});
  test::Camera camera(wall, {}, 3);
  for (int frame = 0; frame < 30; ++frame) {
    const auto seen = camera.see(truth, kFrame_s);
    auto readings = test::readings_of(seen, wall, truth);
    readings.push_back({rival, 2, 1});  // the mount speaks against it: odds of e^-1
    filter.take(instant(frame * kFrame_s), test::members_of(seen, wall), readings);
  }
  const TrackedPose tracked = filter.at(instant(29 * kFrame_s)).value();
  EXPECT_LT((tracked.motion.T_world_camera.translation_m - truth.translation_m).norm(), 0.05);
  EXPECT_NEAR(tracked.ambiguity, 1 / (1 + std::exp(1.0)), 0.02);
  EXPECT_EQ(filter.forecast(instant(29 * kFrame_s))->ambiguity, tracked.ambiguity) << "who is led by it knows";
  double variance_m2 = 0;
  for (int i = 0; i < 3; ++i) variance_m2 += tracked.covariance(i, i);
  EXPECT_GT(variance_m2, 0.2 * (rival.translation_m - truth.translation_m).squaredNorm()) << "the other one's distance";
}

TEST(PoseFilterRules, RaysThatMissMoreThanTheyClaimMakeThePoseLessCertain) {
  const LandmarkMap map = test::room_map();
  PoseFilter filter({});
  test::Camera camera(map, {.ray_px = 0.2, .stated_px = 0.05}, 3);
  Watch honest(map, standing());
  for (int frame = 0; frame < 100; ++frame) {
    const auto seen = camera.see(middle_of_the_room(), kFrame_s);
    filter.take(instant(frame * kFrame_s), test::members_of(seen, map),
                test::readings_of(seen, map, middle_of_the_room()));
    honest.look();
  }
  const TrackedPose tracked = filter.at(instant(99 * kFrame_s)).value();
  EXPECT_LT(honest.tracked().misfit, 1.2);
  EXPECT_NEAR(tracked.misfit, 16, 4);
  EXPECT_EQ(tracked.gated_frames, 0);
  const PoseStep error = step_between(tracked.motion.T_world_camera, middle_of_the_room());
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(std::abs(error(i)), 3 * std::sqrt(tracked.covariance(i, i))) << i;
    EXPECT_GT(tracked.covariance(i, i), 4 * honest.tracked().covariance(i, i)) << i;
  }
}

}  // namespace
}  // namespace ninedot
