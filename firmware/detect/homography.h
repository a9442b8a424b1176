#pragma once
/// Sheet to picture, fitted to dots.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "geometry/plane_point.h"

namespace ninedot {

/// Where a sheet point is seen.
inline Eigen::Vector2d map_point(const Eigen::Matrix3d& H, const Eigen::Vector2d& plane_m) noexcept {
  const Eigen::Vector3d q = H * plane_m.homogeneous();
  return q.hnormalized();
}

/// d(seen)/d(plane) at a sheet point.
Eigen::Matrix2d jacobian_of_map(const Eigen::Matrix3d& H, const Eigen::Vector2d& plane_m) noexcept;

/// Least squares over the matches: a homography (H33 = 1) for five or more, else an affine map. \param matches >= 3
/// \return false when the points are collinear. Memory: none. Threads: pure.
bool fit_plane_map(std::span<const PlanePoint> matches, Eigen::Matrix3d& H) noexcept;

}  // namespace ninedot
