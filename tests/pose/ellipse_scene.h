#pragma once
/// Exact observations of a landmark, for the tests of the ellipse method: discs by their dual conics, no pictures.
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <numbers>
#include <random>
#include <string>

#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "geometry/transform.h"

namespace ninedot::ellipse_scene {

using CameraInLandmark = Transform<frame::Landmark, frame::Camera>;
inline constexpr double kRad = std::numbers::pi / 180;

/// A camera at `distance_m` from P9, `tilt` off the sheet's normal towards `azimuth` (0 = X0, the viewer's left; 90 =
/// Z0, up), upright but for `roll`, turned away from P9 by `yaw` to the right and `pitch` down.
struct View {
  double distance_m = 1, tilt_deg = 30, azimuth_deg = 0, roll_deg = 0, yaw_deg = 0, pitch_deg = 0;

  CameraInLandmark pose() const {
    const double tilt = tilt_deg * kRad, azimuth = azimuth_deg * kRad;
    const Eigen::Vector3d position = distance_m * Eigen::Vector3d(std::sin(tilt) * std::cos(azimuth), std::cos(tilt),
                                                                  std::sin(tilt) * std::sin(azimuth));
    const Eigen::Vector3d forward = -position.normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d R;
    R << right, forward.cross(right), forward;
    R = R * exp_so3({0, 0, roll_deg * kRad}) * exp_so3({0, yaw_deg * kRad, 0}) * exp_so3({-pitch_deg * kRad, 0, 0});
    return {R, position};
  }
};

/// Pinhole picture of one disc, exact: H = K [r_X r_Z centre], Q = H diag(rho^2, rho^2, -1) H^T.
inline DotObservation see_disc(const CameraModel& camera, const CameraInLandmark& T, const Eigen::Vector2d& centre_m,
                               double radius_m) {
  Eigen::Matrix3d K;
  K << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
  const Eigen::Matrix3d R = T.rotation.transpose();
  Eigen::Matrix3d H;
  H << R.col(0), R.col(2), R * (Eigen::Vector3d(centre_m.x(), 0, centre_m.y()) - T.translation_m);
  H = K * H;
  const double rho2 = radius_m * radius_m;
  const Eigen::Matrix3d Q = H * Eigen::Vector3d(rho2, rho2, -1).asDiagonal() * H.transpose();
  DotObservation dot;
  dot.seen = true;
  dot.visible_fraction = 1;
  dot.centroid_px = Q.col(2).head<2>() / Q(2, 2);
  // Centred, the dual conic is [S 0; 0 -1] with S = axes squared.
  const Eigen::Matrix2d S = dot.centroid_px * dot.centroid_px.transpose() - Q.topLeftCorner<2, 2>() / Q(2, 2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(S);
  dot.semi_minor_px = std::sqrt(eigen.eigenvalues()(0));
  dot.semi_major_px = std::sqrt(eigen.eigenvalues()(1));
  const Eigen::Vector2d axis = eigen.eigenvectors().col(1);
  dot.angle_rad = std::atan(axis.y() / axis.x());
  return dot;
}

inline LandmarkObservation see(const CameraModel& camera, const LandmarkGeometry& landmark, const CameraInLandmark& T) {
  LandmarkObservation seen;
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    seen.dots[dot] = see_disc(camera, T, landmark.centre_m(dot), landmark.radius_m(dot));
  seen.seen_count = static_cast<int>(kDotCount);
  return seen;
}

/// \param numbers  1..9 as in P1..P9
inline LandmarkObservation hide(LandmarkObservation seen, std::initializer_list<int> numbers) {
  for (const int number : numbers) {
    seen.dots[static_cast<std::size_t>(number - 1)] = DotObservation{};
    --seen.seen_count;
  }
  return seen;
}

/// Gaussian errors of `sigma_px` per axis on the dots' centres, and on their outlines what goes with that: an outline
/// fit whose centre has the variance s^2 finds the mean radius with s^2 / 2 and each of the two shape terms with s^2.
inline LandmarkObservation add_noise(LandmarkObservation seen, double sigma_px, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0, sigma_px);
  for (DotObservation& dot : seen.dots) {
    if (!dot.seen) continue;
    dot.centroid_px += Eigen::Vector2d(noise(random), noise(random));
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(dot.angle_rad).toRotationMatrix();
    Eigen::Matrix2d shape =
        turn * Eigen::Vector2d(dot.semi_major_px, dot.semi_minor_px).asDiagonal() * turn.transpose();
    const double radius = noise(random) / std::numbers::sqrt2, along = noise(random), across = noise(random);
    shape += (Eigen::Matrix2d() << radius + along, across, across, radius - along).finished();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(shape);
    dot.semi_minor_px = std::max(0.1, eigen.eigenvalues()(0));
    dot.semi_major_px = std::max(dot.semi_minor_px, eigen.eigenvalues()(1));
    dot.angle_rad = std::atan(eigen.eigenvectors()(1, 1) / eigen.eigenvectors()(0, 1));
  }
  return seen;
}

inline double rotation_error_rad(const CameraInLandmark& a, const CameraInLandmark& b) {
  return log_so3(a.rotation.transpose() * b.rotation).norm();
}
inline double position_error_m(const CameraInLandmark& a, const CameraInLandmark& b) {
  return (a.translation_m - b.translation_m).norm();
}

/// Numbers that are the same at every run of one test and differ between tests.
inline std::mt19937_64 random_for(const char* test_name) {
  return std::mt19937_64(std::hash<std::string>{}(test_name));
}

}  // namespace ninedot::ellipse_scene
