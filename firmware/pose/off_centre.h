#pragma once
/// Off-centre correction: (32) to (36) of Martin & Adan, Pattern Recognition 45 (2012) 578-595.
#include <Eigen/Core>

namespace ninedot {

/// Matrix Sd of (36): (u', v', 1) = Sd (u, v, 1), which is u' = (u - u9)(1 + cu u9^2 + cu u9^4) + u9 (32), the same for
/// v (33). The paper prints -u9 (A + 1) in the third column; (32) gives -u9 (A - 1), and so do we.
/// \param p9_px  (u9, v9): P9 from the middle of the picture, distortion removed
/// \param cu, cv  the fitted coefficients; each stands, as printed, for the square [1/px^2] and the fourth power
/// [1/px^4]
/// \return  for u, v in px: the third column's first two in [px], the others [1]
inline Eigen::Matrix3d off_centre_correction(const Eigen::Vector2d& p9_px, double cu, double cv) noexcept {
  const double u2 = p9_px.x() * p9_px.x(), v2 = p9_px.y() * p9_px.y();
  const double A = 1 + cu * u2 + cu * u2 * u2;
  const double B = 1 + cv * v2 + cv * v2 * v2;
  Eigen::Matrix3d Sd;
  Sd << A, 0, -p9_px.x() * (A - 1), 0, B, -p9_px.y() * (B - 1), 0, 0, 1;
  return Sd;
}

}  // namespace ninedot
