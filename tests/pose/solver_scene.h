#pragma once
/// A landmark in usual light, and what the full solver makes of it.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <numbers>

#include "detect/detector.h"
#include "pose/full_solver.h"
#include "tests/support/best_pose.h"
#include "tests/support/renderer.h"

namespace ninedot::test {

inline constexpr double kDegree = std::numbers::pi / 180;

struct Errors {
  Vector6d pose;       ///< position in S0 [m], rotation vector in the camera frame [rad]
  double normalised2;  ///< by the reported covariance
};

inline Errors errors_of(const Scene& scene, const PoseEstimate& estimate) {
  const auto& q = scene.camera.quaternion_wxyz;
  const auto& p = scene.camera.position_m;
  Errors e;
  e.pose.head<3>() = Eigen::Vector3d(p[0], p[1], p[2]) - estimate.T_landmark_camera.translation_m;
  e.pose.tail<3>() = log_so3(estimate.T_landmark_camera.rotation.transpose() *
                             Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix());
  e.normalised2 = e.pose.dot(estimate.covariance.inverse() * e.pose);
  return e;
}

inline Scene scene_at(const Viewpoint& viewpoint, double noise_lsb = 1.5) {
  Scene scene;
  scene.camera = look_at_landmark(viewpoint);
  set_noise(scene.sensor, noise_lsb);
  return scene;
}

inline Result<PoseCandidates> candidates_in(const Picture& picture) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  FullSolver solver(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  if (!seen) return tl::unexpected<Error>(seen.error());
  int pixels = WorkBudget{}.pixels;
  return solver.solve(picture.view(), seen->front(), nullptr, pixels);
}

inline Result<PoseEstimate> pose_of(const Picture& picture) { return best_pose(candidates_in(picture)); }

}  // namespace ninedot::test
