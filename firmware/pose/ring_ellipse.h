#pragma once
/// The ellipse through the ring's dots: (11) to (19) of Martin & Adan, Pattern Recognition 45 (2012) 578-595.
#include <Eigen/Core>
#include <cmath>
#include <span>

#include "base/result.h"

namespace ninedot {

/// Points and lengths are in the unit of the points it was fitted to: at z = 1 [1] in the solver; px would do as well.
/// The paper's axes: x upwards, z to the right.
struct RingEllipse {
  double swing_psi_rad = 0;      ///< of the major axis, from upwards towards the right, (-pi/2, pi/2] (14, 15)
  Eigen::Vector2d centre{0, 0};  ///< (right, down), as the points (19)
  double semi_major = 0;         ///< a (19)
  double semi_minor = 0;         ///< b (19)
};

/// Least-squares fit of A x^2 + B x z + C z^2 + D x + E z = 1 (11 to 13). The origin is moved into the points' mean
/// first: this form can't describe an ellipse through its origin, and the mean lies inside every ellipse.
/// \param points  (right, down), in one unit: z = 1 or px
/// \error kPoseDegenerate: fewer than five points, or the best conic is no ellipse
/// Memory: none. Threads: pure.
Result<RingEllipse> fit_ring_ellipse(std::span<const Eigen::Vector2d> points) noexcept;

/// A point in the ellipse's axes: (x', z'), x' along the major axis turned by `swing_psi_rad` from upwards to the
/// right.
/// \param point  (right, down), relative to the wanted origin, z = 1 or px
/// \return  in the point's unit, z = 1 or px
inline Eigen::Vector2d to_ellipse_axes(const Eigen::Vector2d& point, double swing_psi_rad) noexcept {
  const double x = -point.y(), z = point.x(), c = std::cos(swing_psi_rad), s = std::sin(swing_psi_rad);
  return {c * x + s * z, c * z - s * x};
}

}  // namespace ninedot
