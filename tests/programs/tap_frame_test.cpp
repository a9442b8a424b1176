#include "programs/tap/tap_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>

#include "base/units.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

Report some_report() {
  Report report;
  report.frames = {100, 7, 3, {1, 2, 3, 4, 5}};
  report.frame_number = 4711;
  report.has_pose = report.valid = report.found = report.calibrated = true;
  report.latency = 5ms;
  report.process_time = 700us;
  report.reason = Reason::kNone;
  report.landmark_id = 12;
  report.dots_used = 8;
  report.rms_px = 0.031;
  report.ambiguity = 0.002;
  report.distance_m = 2.5;
  report.tilt_phi_rad = 0.3;
  report.camera_in_landmark = {{0.5, 2.25, -0.125}, {0.5, 0.5, -0.5, 0.5}};
  for (std::size_t i = 0; i < 6; ++i) report.covariance[7 * i] = 1e-6 * static_cast<double>(i + 1);
  return report;
}

TEST(TapFrame, TellsLengthsInMillimetresAndAnglesInDegrees) {
  TapFrame tap;
  describe_frame({}, {}, nullptr, some_report(), tap);
  EXPECT_EQ(tap.camera_in_landmark.position_mm, (std::array{500.0, 2250.0, -125.0}));
  EXPECT_DOUBLE_EQ(tap.camera_in_landmark.sigma_mm[0], 1.0);
  EXPECT_DOUBLE_EQ(tap.camera_in_landmark.sigma_deg[2], std::sqrt(6e-6) * 180 / M_PI);
  EXPECT_DOUBLE_EQ(tap.tilt_deg, 0.3 * 180 / M_PI);
  EXPECT_EQ(tap.latency_ns, 5'000'000);
}

TEST(TapFrame, BecomesTheReportAgainThatAnOverlayDraws) {
  const Report report = some_report();
  TapFrame tap;
  Frame frame;
  frame.number = report.frame_number;
  describe_frame(frame, {}, nullptr, report, tap);
  const Report back = report_of(tap);
  EXPECT_TRUE(back.valid && back.found && back.calibrated && !back.ambiguous);
  EXPECT_EQ(back.landmark_id, report.landmark_id);
  EXPECT_EQ(back.frame_number, report.frame_number);
  EXPECT_EQ(back.process_time, report.process_time);
  EXPECT_EQ(back.camera_in_landmark.quaternion_wxyz, report.camera_in_landmark.quaternion_wxyz);
  EXPECT_NEAR(back.distance_m, report.distance_m, 1e-12);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(back.covariance[7 * i], report.covariance[7 * i], 1e-15);
}

TEST(TapFrame, TellsTheDotsThatAreSeenAndThoseAlone) {
  LandmarkObservation seen, back;
  seen.from_pose = true;
  seen.dots[3] = {true, 0.5F, {12.5, 99.25}, 6, 5, -0.5};
  seen.dots[4] = {false, 0.1F, {1, 1}, 6, 5, 0};
  TapFrame tap;
  describe_frame({}, {}, &seen, some_report(), tap);
  ASSERT_TRUE(observation_of(tap, back));
  EXPECT_EQ(back.seen_count, 1);
  EXPECT_TRUE(back.from_pose && back.dots[3].seen && !back.dots[4].seen);
  EXPECT_EQ(back.dots[3].centroid_px, seen.dots[3].centroid_px);
  EXPECT_NEAR(back.dots[3].angle_rad, -0.5, 1e-12);
  describe_frame({}, {}, nullptr, some_report(), tap);
  EXPECT_FALSE(observation_of(tap, back)) << "those of the frame before";
}

TEST(TapFrame, BringsTheCameraBack) {
  CameraModel camera;
  camera.fx_px = 701, camera.cy_px = 233.5;
  camera.model = DistortionModel::kEquidistant;
  camera.k = {0.1, -0.2, 0.3, -0.4};
  TapHeader header;
  describe_camera(camera, {0.1, 0.02, 0.03}, header);
  const CameraModel back = camera_of(header);
  EXPECT_EQ(back.model, camera.model);
  EXPECT_EQ(back.k, camera.k);
  EXPECT_EQ(back.fx_px, 701);
  EXPECT_EQ(back.cy_px, 233.5);
  EXPECT_DOUBLE_EQ(landmark_of(header).ring_radius_m, 0.1);
  EXPECT_DOUBLE_EQ(landmark_of(header).centre_radius_m, 0.03);
}

TEST(TapFrame, TellsWhyNothingWasFoundAndGivesItBackForAnOverlay) {
  const auto spots = std::make_unique<BlobList>();
  // An ellipse of 8 by 4 px, 30 degrees from +u towards +v: moments are a quarter of the semi-axes' squares.
  const float along = 16, across = 4, cosine = std::cos(0.5236F), sine = std::sin(0.5236F);
  ASSERT_TRUE(
      spots->try_push_back({100, 50, 100, along * cosine * cosine + across * sine * sine,
                            (along - across) * cosine * sine, along * sine * sine + across * cosine * cosine, 1}));
  FailedSearch failed;
  failed.spots = spots->span();
  failed.refusal = Refusal::kNoCentre;
  failed.contrast_lsb = 90;
  failed.noise_lsb = 1.5;
  failed.dots[3] = {true, 0.9F, {120.5, 60.25}, 9, 7, 0.5};
  failed.dots[4] = {false, 0.5F, {130, 70}, 9, 7, 0.5};
  TapFrame tap;
  describe_search(failed, tap);
  EXPECT_EQ(tap.search.spots_seen, 1U);
  EXPECT_NEAR(tap.search.spots[0].semi_major_px, 8, 1e-4);
  EXPECT_NEAR(tap.search.spots[0].semi_minor_px, 4, 1e-4);
  EXPECT_NEAR(tap.search.spots[0].angle_deg, 30, 1e-2);
  const auto read = std::make_unique<BlobList>();
  const auto back = search_of(tap, *read);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->refusal, Refusal::kNoCentre);
  EXPECT_EQ(back->contrast_lsb, 90);
  EXPECT_TRUE(back->dots[3].seen);
  EXPECT_FALSE(back->dots[4].seen);
  EXPECT_EQ(back->dots[3].centroid_px, failed.dots[3].centroid_px);
  ASSERT_EQ(back->spots.size(), 1U);
  EXPECT_NEAR(back->spots[0].xx_px2, (*spots)[0].xx_px2, 1e-4);
  EXPECT_NEAR(back->spots[0].xy_px2, (*spots)[0].xy_px2, 1e-4);
  describe_search(std::nullopt, tap);
  EXPECT_FALSE(search_of(tap, *read)) << "the next frame shows one";
}

TEST(TapFrame, HoldsTheLargestOfMoreSpotsThanItHasRoomForAndSaysHowManyThereWere) {
  const auto spots = std::make_unique<BlobList>();
  for (std::size_t i = 0; i < kTapSpotCount + 50; ++i)
    ASSERT_TRUE(spots->try_push_back({static_cast<float>(i), 0, 9, 1, 0, 1, 0}));
  FailedSearch failed;
  failed.spots = spots->span();
  TapFrame tap;
  describe_search(failed, tap);
  EXPECT_EQ(tap.search.spots_seen, kTapSpotCount + 50);
  EXPECT_EQ(tap.search.spot_count, kTapSpotCount);
  EXPECT_EQ(tap.search.spots.back().u_px, static_cast<float>(kTapSpotCount - 1));
}

}  // namespace
}  // namespace ninedot
