#pragma once
/// A point of the landmark's plane Y0 = 0 and where it was seen.
#include <Eigen/Core>

namespace ninedot {

struct PlanePoint {
  Eigen::Vector2d plane_m;  ///< (X0, Z0)
  Eigen::Vector2d seen;     ///< in the unit that the caller works in: px, or its ray at z = 1, distortion removed
  double weight = 1;        ///< of its squared residual, >= 0
};

}  // namespace ninedot
