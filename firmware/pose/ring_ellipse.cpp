#include "pose/ring_ellipse.h"

#include <Eigen/Cholesky>

namespace ninedot {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

/// One row of Z (13).
Vector5d conic_row(const Eigen::Vector2d& p) noexcept {
  const double x = -p.y(), z = p.x();
  Vector5d row;
  row << x * x, x * z, z * z, x, z;
  return row;
}

/// (14, 15), but for the major axis: A' (17) is smallest along it. atan(B / (A - C)) / 2 alone leaves the two axes
/// open.
double major_axis_swing_rad(const Vector5d& h) noexcept {
  const double psi_rad = 0.5 * std::atan2(-h(1), h(2) - h(0));
  return psi_rad;
}

}  // namespace

Result<RingEllipse> fit_ring_ellipse(std::span<const Eigen::Vector2d> points) noexcept {
  if (points.size() < 5) return fail(Errc::kPoseDegenerate, "an ellipse needs five points");
  const double count = static_cast<double>(points.size());
  Eigen::Vector2d mean(0, 0);
  for (const Eigen::Vector2d& p : points) mean += p / count;
  double squares = 0;
  for (const Eigen::Vector2d& p : points) squares += (p - mean).squaredNorm();
  const double size = std::sqrt(squares / count);
  if (!(size > 0) || !std::isfinite(size))
    return fail(Errc::kPoseDegenerate, "the points of an ellipse coincide or are no numbers");

  Matrix5d N = Matrix5d::Zero();
  for (const Eigen::Vector2d& p : points) {
    const Vector5d row = conic_row((p - mean) / size);
    N += row * row.transpose();
  }
  const Eigen::LDLT<Matrix5d> factors(N);
  Vector5d h = Vector5d::Zero();
  for (int pass = 0; pass < 2; ++pass) {  // the second pass gives back the digits that squaring Z has cost
    Vector5d g = Vector5d::Zero();
    for (const Eigen::Vector2d& p : points) {
      const Vector5d row = conic_row((p - mean) / size);
      g += row * (1 - row.dot(h));
    }
    h += factors.solve(g);
  }

  const double psi_rad = major_axis_swing_rad(h);
  const double c = std::cos(psi_rad), s = std::sin(psi_rad);
  const double A = h(0) * c * c + h(1) * s * c + h(2) * s * s;  // (17), primes left out
  const double C = h(0) * s * s - h(1) * s * c + h(2) * c * c;
  const double D = h(3) * c + h(4) * s;
  const double E = h(4) * c - h(3) * s;
  constexpr double F = -1;
  const double M = D * D / (4 * A) + E * E / (4 * C) - F;  // (18)
  if (!(A > 0 && C > 0 && M > 0 && std::isfinite(M)))
    return fail(Errc::kPoseDegenerate, "the ring's dots do not lie on an ellipse");
  const double x = -D / (2 * A), z = -E / (2 * C);  // (19), in the rotated axes
  RingEllipse ellipse;
  ellipse.swing_psi_rad = psi_rad;
  ellipse.centre = mean + size * Eigen::Vector2d(s * x + c * z, -(c * x - s * z));
  ellipse.semi_major = size * std::sqrt(M / A);
  ellipse.semi_minor = size * std::sqrt(M / C);
  return ellipse;
}

}  // namespace ninedot
