#pragma once
/// Sheet to picture, fitted to dots.
///
/// A map H takes sheet points (X0, Z0) [m] to where they are seen: (seen, 1) ~ H (plane, 1), whatever H's scale. What
/// `seen` is measured in is H's affair: px of a picture, or rays at z = 1. The inverse of a map into px takes those to
/// m.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "geometry/plane_point.h"

namespace ninedot {

/// Where a sheet point is seen. \param H  from [m] to px or z = 1
/// \return  in px or at z = 1, as H makes it
inline Eigen::Vector2d map_point(const Eigen::Matrix3d& H, const Eigen::Vector2d& plane_m) noexcept {
  const Eigen::Vector3d q = H * plane_m.homogeneous();
  return q.hnormalized();
}

/// d(seen)/d(plane) at a sheet point. \param H  from [m] to px or z = 1
/// \return  [px/m], or [1/m] at z = 1
Eigen::Matrix2d jacobian_of_map(const Eigen::Matrix3d& H, const Eigen::Vector2d& plane_m) noexcept;

/// Least squares over the matches: a homography (H33 = 1) for five or more, else an affine map. \param matches  >= 3
/// \param H  from [m] to px or z = 1, whichever the matches are seen in: its third row [1/m] [1/m] [1], the others
/// [px/m] [px/m] [px], or as the third
/// \return  false when the points are collinear. Memory: none. Threads: pure.
bool fit_plane_map(std::span<const PlanePoint> matches, Eigen::Matrix3d& H) noexcept;

}  // namespace ninedot
