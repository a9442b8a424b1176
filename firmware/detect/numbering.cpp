#include "detect/numbering.h"

#include <algorithm>
#include <cmath>

#include "detect/homography.h"
#include "geometry/planar_pose.h"

namespace ninedot {

NumberingCosts numbering_costs(std::span<const PlanePoint> points, const Eigen::Matrix3d& H_ray_plane,
                               const LandmarkGeometry& landmark, const UprightPrior& prior) noexcept {
  Eigen::Vector3d X = H_ray_plane.col(0).normalized();
  Eigen::Vector3d Z = H_ray_plane.col(1).normalized();
  Eigen::Vector3d to_camera = -H_ray_plane.col(2).normalized();
  if (const auto pose = solve_likelier_planar_pose(points)) {
    X = pose->T_camera_landmark.rotation.col(0);
    Z = pose->T_camera_landmark.rotation.col(2);
    to_camera = -pose->T_camera_landmark.translation_m.normalized();
  }
  NumberingCosts costs = upright_costs(X, Z, to_camera, landmark, prior);
  const double least = *std::min_element(costs.begin(), costs.end());
  for (double& cost : costs) cost -= least;
  return costs;
}

std::optional<int> first_dot_by_forecast(const Eigen::Matrix3d& H_ray_plane,
                                         const Eigen::Matrix3d& H_ray_plane_forecast,
                                         const LandmarkGeometry& landmark) noexcept {
  const auto around_centre = [&](const Eigen::Matrix3d& H, std::size_t dot) -> Eigen::Vector2d {
    return map_point(H, landmark.centre_m(dot)) - map_point(H, landmark.centre_m(kCentreDot));
  };
  double size = 0;
  for (std::size_t k = 0; k < kRingDotCount; ++k) size += around_centre(H_ray_plane_forecast, k).squaredNorm();
  std::optional<int> best;
  double least = kForecastMet * kForecastMet * size;
  for (std::size_t first = 0; first < kRingDotCount; ++first) {
    double apart = 0;
    for (std::size_t k = 0; k < kRingDotCount; ++k)
      apart += (around_centre(H_ray_plane, (first + k) % kRingDotCount) - around_centre(H_ray_plane_forecast, k))
                   .squaredNorm();
    if (apart < least) least = apart, best = static_cast<int>(first);
  }
  return best;
}

}  // namespace ninedot
