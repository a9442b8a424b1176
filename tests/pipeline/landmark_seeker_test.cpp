// What a way to a pose says of itself beside the pose.
#include "pipeline/landmark_seeker.h"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// A landmark's track knows its motion after two frames; both were fitted without.
TEST(LandmarkSeeker, SaysHowWellTheMotionAcrossRowsWasKnownWhenItWasFitted) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.5, .tilt_rad = 0.4, .azimuth_rad = 0.7});
  scene.sheets = {test::nine_dot_sheet()};
  set_noise(scene.sensor, 1.5);
  const test::Picture picture = test::render(scene, 1);
  LandmarkSeeker seeker(CameraModel{}, {.row_time = 33us});
  Track track(TrackOptions{});
  for (int number = 0; number < 4; ++number) {
    Frame frame;
    frame.luma = picture.view();
    frame.set_exposure(MonoTime(1s) + number * 28ms, 4ms);
    seeker.begin(frame, WorkBudget{});
    auto found = number > 0 ? seeker.detect_near_track(frame, track) : [&] {
      const auto seen = seeker.detector().find_landmarks(frame.luma);
      return seen ? seeker.solve_guess(frame, seen->front(), track) : tl::unexpected(seen.error());
    }();
    ASSERT_TRUE(found) << number;
    EXPECT_EQ(track.motion_at(frame.exposed_at()).has_value(), number > 0) << number;
    const RowMotion& fitted = seeker.row_motion();
    EXPECT_EQ(fitted.sheet.row_time_s, 33e-6) << number;
    if (number < 2) {
      EXPECT_GT(fitted.uncertainty.rate_sigma_rad_s, 0.5) << number;
      EXPECT_EQ(fitted.sheet.translation_m_s.norm(), 0) << number;
    } else {
      EXPECT_LT(fitted.uncertainty.rate_sigma_rad_s, 0.01) << number;
    }
  }
}

}  // namespace
}  // namespace ninedot
