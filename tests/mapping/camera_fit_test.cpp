#include "mapping/camera_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mapping/chi_square.h"

namespace ninedot {
namespace {

const LandmarkGeometry kSheet{};

/// The sheet from `distance_m` away, the camera turned round it by `angle_rad`.
CameraFromLandmark seen_from(double distance_m, double angle_rad) {
  Eigen::Matrix3d R;  // the camera looks along -Y of the sheet
  R << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  return {R * exp_so3({0, 0, angle_rad}), {0.1, -0.05, distance_m}};
}

LandmarkSighting sighting_of(const CameraFromLandmark& T, double sigma) {
  LandmarkSighting seen;
  seen.T_camera_landmark = T;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d at = kSheet.centre_m(dot);
    seen.dots[dot].ray = (T * Eigen::Vector3d(at.x(), 0, at.y())).hnormalized();
    seen.dots[dot].information = Eigen::Matrix2d::Identity() / (sigma * sigma);
  }
  return seen;
}

double angle(const CameraFromLandmark& a, const CameraFromLandmark& b) {
  return log_so3(a.rotation.transpose() * b.rotation).norm();
}

TEST(OwnPoses, AreTheTruePoseAndItsMirrorImageWhereTheSheetIsSmall) {
  const CameraFromLandmark T = seen_from(4, 0.4);
  const OwnPoses poses = own_poses(sighting_of(T, 1e-4), kSheet);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_LT(angle(poses[0].T_camera_landmark, T), 1e-6);
  EXPECT_LT(poses[0].chi2, 1e-9);
  EXPECT_NEAR(angle(poses[1].T_camera_landmark, T), 0.8, 0.1) << "the tilt to the other side";
  EXPECT_GT(poses[1].chi2, poses[0].chi2);
}

TEST(OwnPoses, FindTheTrueOneWhenTheSightingBringsTheMirrorImage) {
  const CameraFromLandmark T = seen_from(2, 0.5);
  LandmarkSighting seen = sighting_of(T, 2e-5);
  seen.T_camera_landmark = seen_from(2, -0.5);
  const OwnPoses poses = own_poses(seen, kSheet);
  ASSERT_GE(poses.size(), 1U);
  EXPECT_LT(angle(poses[0].T_camera_landmark, T), 1e-6);
}

TEST(OwnPoses, AreOneWhereTheMirrorImageIsOutOfTheQuestion) {
  EXPECT_EQ(own_poses(sighting_of(seen_from(0.6, 0.7), 1e-5), kSheet).size(), 1U);
}

TEST(OwnPoses, AreNoneWithThreeDots) {
  LandmarkSighting seen = sighting_of(seen_from(2, 0.5), 1e-4);
  for (std::size_t dot = 3; dot < kDotCount; ++dot) seen.dots[dot] = {};
  EXPECT_TRUE(own_poses(seen, kSheet).empty());
}

TEST(CameraFit, FindsTheCameraFromTwoSheets) {
  const WorldFromCamera camera{exp_so3({0.1, -0.2, 0.3}), {1, 2, 3}};
  const LandmarkSighting a = sighting_of(seen_from(2, 0.5), 1e-4), b = sighting_of(seen_from(3, -0.4), 1e-4);
  const std::vector<PlacedSighting> placed{{&a, camera * a.T_camera_landmark}, {&b, camera * b.T_camera_landmark}};
  PoseStep off;
  off << 0.2, -0.1, 0.3, 0.05, 0.1, -0.1;
  const CameraFit fit = fit_camera(placed, moved_by(camera, off), kSheet);
  EXPECT_LT(step_between(fit.T_world_camera, camera).norm(), 1e-7);
  EXPECT_LT(fit.chi2, 1e-6);
}

/// Closed form for an even number of freedoms: exp(-x/2) times the first terms of exp(x/2).
double share_above(double chi2, int freedoms) {
  double term = 1, sum = 0;
  for (int i = 0; i < freedoms / 2; ++i) sum += term, term *= chi2 / 2 / (i + 1);
  return std::exp(-chi2 / 2) * sum;
}

TEST(ChiSquare, LimitIsExceededWithTheStatedProbability) {
  for (const int freedoms : {6, 12, 18, 90}) {
    EXPECT_GT(share_above(0.96 * chi2_limit(freedoms), freedoms), kFalseAlarm) << freedoms;
    EXPECT_LT(share_above(chi2_limit(freedoms), freedoms), kFalseAlarm) << freedoms;
    EXPECT_NEAR(share_above(chi2_median(freedoms), freedoms), 0.5, 0.005) << freedoms;
  }
}

}  // namespace
}  // namespace ninedot
