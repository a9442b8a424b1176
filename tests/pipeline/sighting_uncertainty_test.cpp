#include "pipeline/sighting_uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ninedot {
namespace {

LandmarkSighting at_row(double row_px, const CameraModel& camera) {
  LandmarkSighting sighting;
  sighting.T_camera_landmark.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  sighting.T_camera_landmark.translation_m = {0, 4 * (row_px - camera.cy_px) / camera.fy_px, 4};
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
    sighting.dots[dot].ray = (sighting.T_camera_landmark * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized();
    sighting.dots[dot].information = Eigen::Matrix2d::Identity() * std::pow(camera.fx_px / 0.03, 2);
  }
  return sighting;
}

TEST(SightingUncertainty, RowsAwayFromTheMiddleTurnTheWholeLandmark) {
  const CameraModel camera;
  const RowUncertainty rows{.of_motion_rad = 0.02 * 33e-6, .middle_row_px = 0.5 * (camera.height_px - 1)};
  const LandmarkSighting before = at_row(rows.middle_row_px + 200, camera);
  LandmarkSighting sighting = before;
  widen(sighting, rows, camera, true);
  EXPECT_NEAR(sighting.turn_sigma_rad, 0.02 * 200 * 33e-6, 1e-7);
  // A dot's own rows lie ten from the landmark's: 0.005 px, nine times counted for nine dots.
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const double kept = sighting.dots[dot].information.trace() / before.dots[dot].information.trace();
    EXPECT_LE(kept, 1) << dot;
    EXPECT_GT(kept, 0.6) << dot;
  }
  EXPECT_LT(sighting.dots[0].information.trace(), sighting.dots[2].information.trace()) << "further from the middle";
}

TEST(SightingUncertainty, NothingIsUncertainWhereAllRowsAreExposedAtOnce) {
  const CameraModel camera;
  LandmarkSighting sighting = at_row(400, camera);
  const Eigen::Matrix2d before = sighting.dots[0].information;
  widen(sighting, {.middle_row_px = 239.5}, camera, true);
  EXPECT_EQ(sighting.turn_sigma_rad, 0);
  EXPECT_EQ(sighting.dots[0].information, before);
}

TEST(SightingUncertainty, OfAFirstPictureCountsWhereTheCameraMayMoveInIt) {
  const CameraModel camera;
  const RowUncertainty rows{.of_both_rad = 0.7 * 33e-6, .middle_row_px = 239.5};
  LandmarkSighting stands = at_row(400, camera), moves = at_row(400, camera);
  widen(stands, rows, camera, false);
  widen(moves, rows, camera, true);
  EXPECT_EQ(stands.turn_sigma_rad, 0);
  EXPECT_NEAR(moves.turn_sigma_rad, 0.7 * 33e-6 * 160.5, 1e-5);
}

TEST(SightingUncertainty, ALineThatDotsDrawMovesAllOfThemAlike) {
  const CameraModel camera;
  OutlineState outlines;
  LandmarkSighting sighting = at_row(300, camera);
  PoseEstimate pose;
  pose.T_landmark_camera = sighting.T_camera_landmark.inverse();
  pose.covariance = Matrix6d::Identity() * 1e-10;
  sighting.turn_sigma_rad = 3e-5;
  const LandmarkSighting before = sighting;
  const PoseEstimate pose_before = pose;
  widen_by_smear(sighting, outlines, camera), widen_by_smear(pose, outlines, camera);
  EXPECT_EQ(sighting.turn_sigma_rad, before.turn_sigma_rad) << "it stands";
  EXPECT_EQ(pose.covariance, pose_before.covariance);
  constexpr double kLine_px = 6.5;
  outlines.blur_px2 += kLine_px * kLine_px / 24, outlines.blur_sin_px2 = kLine_px * kLine_px / 24;
  widen_by_smear(sighting, outlines, camera), widen_by_smear(pose, outlines, camera);
  const double turn_rad = 0.005 * kLine_px / camera.fx_px;
  EXPECT_NEAR(sighting.turn_sigma_rad, std::hypot(3e-5, turn_rad), 1e-9);
  EXPECT_EQ(sighting.dots[3].information, before.dots[3].information) << "about each other they are where they were";
  const double distance_m = sighting.T_camera_landmark.translation_m.norm();
  EXPECT_NEAR(std::sqrt(pose.covariance(0, 0)), std::hypot(1e-5, turn_rad * distance_m), 1e-7);
  EXPECT_NEAR(std::sqrt(pose.covariance(4, 4)), std::hypot(1e-5, turn_rad), 1e-9);
  // And what the rows make of it comes to that.
  widen(sighting, {.of_motion_rad = 1e-6, .middle_row_px = 200}, camera, false);
  EXPECT_NEAR(sighting.turn_sigma_rad, std::hypot(3e-5, turn_rad, 1e-6 * 100), 1e-8);
}

TEST(SightingUncertainty, LongLinesMoveDotsAboutEachOther) {
  const CameraModel camera;
  constexpr double kLine_px = 10;
  OutlineState outlines;
  outlines.blur_px2 += kLine_px * kLine_px / 24, outlines.blur_cos_px2 = kLine_px * kLine_px / 24;
  LandmarkSighting sighting = at_row(300, camera);
  PoseEstimate pose;
  pose.covariance = Matrix6d::Identity() * 1e-4;
  const LandmarkSighting before = sighting;
  widen_by_smear(sighting, outlines, camera), widen_by_smear(pose, outlines, camera);
  EXPECT_NEAR(before.dots[2].information(0, 0) / sighting.dots[2].information(0, 0), std::pow(kLine_px / 7, 2), 1e-6);
  EXPECT_NEAR(pose.covariance(0, 0) / 1e-4, std::pow(kLine_px / 7, 2), 1e-3);
}

}  // namespace
}  // namespace ninedot
