#include "detect/homography.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ninedot {

Eigen::Matrix2d jacobian_of_map(const Eigen::Matrix3d& H, const Eigen::Vector2d& plane_m) noexcept {
  const Eigen::Vector3d q = H * plane_m.homogeneous();
  const Eigen::Vector2d seen = q.hnormalized();
  Eigen::Matrix2d J;
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) J(row, column) = (H(row, column) - seen(row) * H(2, column)) / q.z();
  return J;
}

bool fit_plane_map(std::span<const PlanePoint> matches, Eigen::Matrix3d& H) noexcept {
  if (matches.size() < 3) return false;
  const auto count = static_cast<double>(matches.size());
  Eigen::Vector2d plane_mean(0, 0), seen_mean(0, 0);
  for (const PlanePoint& m : matches) plane_mean += m.plane_m / count, seen_mean += m.seen / count;
  double plane_scale = 0, seen_scale = 0;
  for (const PlanePoint& m : matches) {
    plane_scale += (m.plane_m - plane_mean).norm() / count;
    seen_scale += (m.seen - seen_mean).norm() / count;
  }
  if (!(plane_scale > 0) || !(seen_scale > 0)) return false;

  // Unknowns a..h of u = (a X + b Z + c) / (g X + h Z + 1), v likewise, linearised by multiplying the denominator out.
  using Matrix8d = Eigen::Matrix<double, 8, 8>;
  using Vector8d = Eigen::Matrix<double, 8, 1>;
  const bool projective = matches.size() >= 5;
  Matrix8d A = Matrix8d::Zero();
  Vector8d b = Vector8d::Zero();
  for (const PlanePoint& m : matches) {
    const Eigen::Vector2d P = (m.plane_m - plane_mean) / plane_scale;
    const Eigen::Vector2d s = (m.seen - seen_mean) / seen_scale;
    for (int axis = 0; axis < 2; ++axis) {
      Vector8d row = Vector8d::Zero();
      row.segment<3>(3 * axis) = P.homogeneous();
      if (projective) row.tail<2>() = -s(axis) * P;
      A.noalias() += row * row.transpose();
      b.noalias() += row * s(axis);
    }
  }
  if (!projective) A(6, 6) = A(7, 7) = 1;
  const Eigen::LDLT<Matrix8d> ldlt(A);
  const auto pivots = ldlt.vectorD();
  if (!(pivots.minCoeff() > 1e-9 * pivots.maxCoeff())) return false;
  const Vector8d h = ldlt.solve(b);

  Eigen::Matrix3d Hn;
  Hn << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), 1;
  Eigen::Matrix3d from_plane = Eigen::Matrix3d::Identity(), to_seen = Eigen::Matrix3d::Identity();
  from_plane(0, 0) = from_plane(1, 1) = 1 / plane_scale;
  from_plane.topRightCorner<2, 1>() = -plane_mean / plane_scale;
  to_seen(0, 0) = to_seen(1, 1) = seen_scale;
  to_seen.topRightCorner<2, 1>() = seen_mean;
  H = to_seen * Hn * from_plane;
  if (std::abs(H(2, 2)) < 1e-12) return false;
  H /= H(2, 2);
  return H.allFinite();
}

}  // namespace ninedot
