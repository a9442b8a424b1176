#include "pose/pose_of_places.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "pose/mirror_image.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

const LandmarkGeometry kSheet;
constexpr double kFocal_px = 600, kSigma = 0.05 / kFocal_px;

CameraFromLandmark sheet_at(double distance_m, const Eigen::Vector3d& turn_rad) {
  CameraFromLandmark T;
  T.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;  // upright: its normal towards the camera
  T.rotation = exp_so3(turn_rad) * T.rotation;
  T.translation_m = {0.2, -0.1, distance_m};
  return T;
}

DotSightings seen_from(const CameraFromLandmark& T) {
  DotSightings dots;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = kSheet.centre_m(dot);
    dots[dot].ray = (T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized();
    dots[dot].information = Eigen::Matrix2d::Identity() / (kSigma * kSigma);
  }
  return dots;
}

/// Of (rotation about the landmark's origin, translation).
Vector6d step_between(const CameraFromLandmark& from, const CameraFromLandmark& to) {
  Vector6d step;
  step << log_so3(to.rotation * from.rotation.transpose()), to.translation_m - from.translation_m;
  return step;
}

TEST(PoseOfPlaces, IsThePoseThatTheDotsWereSeenFrom) {
  for (const double distance_m : {0.7, 2.0, 5.0}) {
    const CameraFromLandmark T = sheet_at(distance_m, {0.4, -0.3, 0.1});
    CameraFromLandmark start = T;
    start.rotation = exp_so3({0.05, 0.05, -0.1}) * start.rotation;
    start.translation_m *= 1.05;
    const auto pose = fit_to_places(seen_from(T), kSheet, start);
    ASSERT_TRUE(pose) << distance_m;
    EXPECT_LT(step_between(T, pose->T_camera_landmark).norm(), 1e-5) << distance_m;
  }
}

TEST(PoseOfPlaces, IsAsUncertainAsTheNoiseOfTheDotsMakesIt) {
  constexpr int kPictures = 300;
  const CameraFromLandmark T = sheet_at(2, {0.5, -0.3, 0});
  test::Random random(7);
  double sum = 0;
  for (int i = 0; i < kPictures; ++i) {
    DotSightings dots = seen_from(T);
    // Known twice as well along x as along y.
    for (DotSighting& dot : dots) {
      const double x = random.normal();
      dot.ray += kSigma * Eigen::Vector2d(0.5 * x, random.normal());
      dot.information(0, 0) *= 4;
    }
    const auto pose = fit_to_places(dots, kSheet, T);
    ASSERT_TRUE(pose);
    const Vector6d error = step_between(T, pose->T_camera_landmark);
    sum += error.dot(pose->covariance.ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kPictures, 6, 0.6) << "chi^2 of six freedoms, 3 sigma of its mean";
}

TEST(PoseOfPlaces, FromItsReflectionIsTheMirrorImage) {
  for (const double distance_m : {1.0, 3.0, 6.0}) {
    const CameraFromLandmark T = sheet_at(distance_m, {0.4, -0.3, 0.1}), mirror = mirror_image(T, kSheet);
    const auto pose = fit_to_places(seen_from(T), kSheet, reflected(T));
    ASSERT_TRUE(pose) << distance_m;
    EXPECT_LT(angle_between_rad(pose->T_camera_landmark, mirror), 1e-3) << distance_m;
    EXPECT_GT(angle_between_rad(pose->T_camera_landmark, T), 0.5) << distance_m;
  }
}

TEST(PoseOfPlaces, IsNoneOfTwoDotsOrBehindTheCamera) {
  const CameraFromLandmark T = sheet_at(2, {0.4, -0.3, 0.1});
  DotSightings two = seen_from(T);
  for (std::size_t dot = 2; dot < kDotCount; ++dot) two[dot].information.setZero();
  EXPECT_FALSE(fit_to_places(two, kSheet, T));
  CameraFromLandmark behind = T;
  behind.translation_m.z() *= -1;
  EXPECT_FALSE(fit_to_places(seen_from(T), kSheet, behind));
}

}  // namespace
}  // namespace ninedot
