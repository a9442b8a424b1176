#include "world/foretold_ring.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ninedot {

double foretold_ray_sigma(const WorldFromCamera& T_world_camera, const PoseCovariance& covariance,
                          const WorldFromLandmark& T_world_landmark, const PoseCovariance& place_covariance,
                          const LandmarkGeometry& landmark) noexcept {
  const PoseCovariance of_step =
      covariance + step_covariance_of_place(place_covariance, T_world_landmark, T_world_camera);
  const auto T_camera_landmark = T_world_camera.inverse() * T_world_landmark;
  double largest = 0;
  for (std::size_t dot = 0; dot < kRingDotCount; dot += 2) {
    const Eigen::Vector2d C = landmark.centre_m(dot);
    const Eigen::Vector3d p_m = T_camera_landmark * Eigen::Vector3d(C.x(), 0, C.y());
    if (!(p_m.z() > 0)) return std::numeric_limits<double>::infinity();
    Eigen::Matrix3d p_cross;
    p_cross << 0, -p_m.z(), p_m.y(), p_m.z(), 0, -p_m.x(), -p_m.y(), p_m.x(), 0;
    Eigen::Matrix<double, 3, 6> dp;
    dp << -T_world_camera.rotation.transpose(), p_cross;
    Eigen::Matrix<double, 2, 3> dray;
    dray << 1, 0, -p_m.x() / p_m.z(), 0, 1, -p_m.y() / p_m.z();
    const Eigen::Matrix<double, 2, 6> J = dray / p_m.z() * dp;
    const Eigen::Matrix2d of_ray = J * of_step * J.transpose();
    const double half = 0.5 * (of_ray(0, 0) + of_ray(1, 1));
    const double apart = std::hypot(0.5 * (of_ray(0, 0) - of_ray(1, 1)), of_ray(0, 1));
    largest = std::max(largest, half + apart);
  }
  return std::sqrt(largest);
}

}  // namespace ninedot
