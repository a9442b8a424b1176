// Poses that dots with known noise were seen from, nearly from in front.
#include "pose/tilt_spread.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>

#include "geometry/planar_pose.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kRaySigma = 0.03 / 720;
const LandmarkGeometry kSheet;

/// Inclined towards the direction `azimuth_rad` in the picture.
CameraFromLandmark sheet_at(double distance_m, double tilt_rad, double azimuth_rad) {
  CameraFromLandmark T;
  T.translation_m = {0.1, -0.05, distance_m};
  Eigen::Matrix3d in_front;  // X0 to the viewer's left, Z0 up, the normal to the camera
  in_front << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  T.rotation = exp_so3(tilt_rad * Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0)) * in_front;
  return T;
}

DotSightings seen_from(const CameraFromLandmark& T, test::Random& random) {
  DotSightings dots;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = kSheet.centre_m(dot);
    dots[dot].ray = (T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized() +
                    kRaySigma * Eigen::Vector2d(random.normal(), random.normal());
    dots[dot].information = Eigen::Matrix2d::Identity() / (kRaySigma * kRaySigma);
  }
  return dots;
}

/// The likeliest pose.
CameraFromLandmark crest_of(const DotSightings& dots) {
  std::array<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) points[dot] = {kSheet.centre_m(dot), dots[dot].ray};
  return (*solve_planar_pose(points))[0].T_camera_landmark;
}

/// By the curvature there.
Matrix6d covariance_at(const CameraFromLandmark& T) {
  Matrix6d information = Matrix6d::Zero();
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = kSheet.centre_m(dot);
    const Eigen::Vector3d q = T.rotation * Eigen::Vector3d(C.x(), 0, C.y()), p = q + T.translation_m;
    Eigen::Matrix<double, 2, 3> seen;
    seen << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z();
    Eigen::Matrix3d q_cross;
    q_cross << 0, -q.z(), q.y(), q.z(), 0, -q.x(), -q.y(), q.x(), 0;
    Eigen::Matrix<double, 2, 6> J;
    J << -seen * q_cross, seen;
    J /= p.z() * kRaySigma;
    information += J.transpose() * J;
  }
  return information.inverse();
}

TEST(TiltSpread, LeavesTheCovarianceOfASteepViewAlone) {
  test::Random random(1);
  for (const double tilt_deg : {25.0, 50.0}) {
    const DotSightings dots = seen_from(sheet_at(2, tilt_deg * kDegree, 1), random);
    const CameraFromLandmark T = crest_of(dots);
    EXPECT_EQ(covariance_over_tilts(T, dots, kSheet, covariance_at(T)), covariance_at(T));
  }
}

TEST(TiltSpread, IsTheMeanSquareOfTheErrorsMadeNearlyInFront) {
  test::Random random(2);
  double by_curvature = 0, by_spread = 0;
  int poses = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    // As likely from one direction as from another: spread evenly over a disc of tilts.
    const double tilt_rad = 6 * kDegree * std::sqrt(random.uniform(0, 1));
    const CameraFromLandmark truth = sheet_at(random.uniform(3, 4.5), tilt_rad, random.uniform(-3.1416, 3.1416));
    const DotSightings dots = seen_from(truth, random);
    const CameraFromLandmark T = crest_of(dots);
    const Matrix6d curvature = covariance_at(T), spread = covariance_over_tilts(T, dots, kSheet, curvature);
    if (spread == curvature) continue;
    Vector6d error;
    error << log_so3(truth.rotation * T.rotation.transpose()), truth.translation_m - T.translation_m;
    by_curvature += error.dot(curvature.ldlt().solve(error));
    by_spread += error.dot(spread.ldlt().solve(error));
    ++poses;
  }
  RecordProperty("poses", poses);
  RecordProperty("by_curvature", std::to_string(by_curvature / poses));
  RecordProperty("by_spread", std::to_string(by_spread / poses));
  ASSERT_GT(poses, 500);
  EXPECT_GT(by_curvature / poses, 9) << "the test shows nothing";
  EXPECT_NEAR(by_spread / poses, 6, 0.6);
}

}  // namespace
}  // namespace ninedot
