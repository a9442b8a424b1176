/// Forward: the textbook formulas, with Jacobians by hand. Inverse: first along the radius, where Newton's method is
/// bracketed and the first turning point of the lens function ends the search; then, for the tangential terms, Newton's
/// method in two dimensions from there. A lens function is only trusted up to its first turning point: beyond it the
/// polynomial folds back and a pixel would have several sources.
#include "geometry/camera_model.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

namespace ninedot {
namespace {

// Bisection alone reaches the 2^-53 of a double in 53 steps; Newton's method, with the lenses below, needs 7 at most.
constexpr int kMaxRadialSteps = 80;
// Counted over pictures of 640 x 480 px, f = 400 px, of strong lenses (k1 from -0.42 to 0.3, p to 0.02): 5 at most.
constexpr int kMaxPlaneSteps = 20;
constexpr double kResidualLimit = 1e-10;  // of z = 1; 1e-7 px at fx = 1000
// Where a lens function is checked for turning points on the way out; its slope has 6 roots at most.
constexpr int kSlopeSamples = 32;
constexpr double kMaxEquidistantTheta_rad = std::numbers::pi / 2 - 1e-6;  // z = 1 holds directions in front only

/// A lens function of one variable: distance from the axis in the picture (at f = 1), and its derivative.
struct LensValue {
  double value;
  double slope;
};

/// r (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6), the radial part of plumb_bob and
/// rational_polynomial.
LensValue polynomial_lens(const std::array<double, 8>& k, double r) noexcept {
  const double s = r * r;
  const double numerator = 1 + s * (k[0] + s * (k[1] + s * k[4]));
  const double numerator_ds = k[0] + s * (2 * k[1] + s * 3 * k[4]);
  const double denominator = 1 + s * (k[5] + s * (k[6] + s * k[7]));
  const double denominator_ds = k[5] + s * (2 * k[6] + s * 3 * k[7]);
  if (denominator <= 0) return {std::numeric_limits<double>::infinity(), -1};  // past a pole: outside the valid field
  const double q = numerator / denominator;
  const double q_ds = (numerator_ds - q * denominator_ds) / denominator;
  return {r * q, q + 2 * s * q_ds};
}

/// theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
LensValue equidistant_lens(const std::array<double, 8>& k, double theta_rad) noexcept {
  const double s = theta_rad * theta_rad;
  return {theta_rad * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])))),
          1 + s * (3 * k[0] + s * (5 * k[1] + s * (7 * k[2] + s * 9 * k[3])))};
}

/// Whether the function rises all the way from 0 to x.
template <typename Lens>
bool rises_up_to(const Lens& lens, double x) noexcept {
  for (int i = 1; i <= kSlopeSamples; ++i)
    if (!(lens(x * i / kSlopeSamples).slope > 0)) return false;
  return true;
}

/// x >= 0 with lens(x).value = target, at most `limit` (may be infinite); a negative number where there is none.
template <typename Lens>
double invert_lens(const Lens& lens, double target, double limit) noexcept {
  constexpr double kNone = -1;
  if (!(target >= 0) || !std::isfinite(target)) return kNone;
  double low = 0;
  double high = limit;
  double x = std::fmin(target, 0.5 * limit);
  for (int step = 0; step < kMaxRadialSteps; ++step) {
    const LensValue at = lens(x);
    if (std::abs(at.value - target) <= 1e-15 * (1 + target) && at.slope > 0) break;
    (at.value < target && at.slope > 0 ? low : high) = x;
    double next = at.slope > 0 ? x - (at.value - target) / at.slope : low;
    if (!(next > low && next < high)) next = std::isinf(high) ? 2 * x : 0.5 * (low + high);
    if (next == x) break;
    x = next;
  }
  const bool found = std::abs(lens(x).value - target) <= kResidualLimit && x < limit && rises_up_to(lens, x);
  return found ? x : kNone;
}

Eigen::Vector2d distort_polynomial(const std::array<double, 8>& k, const Eigen::Vector2d& p,
                                   Eigen::Matrix2d* jacobian) noexcept {
  const double x = p.x(), y = p.y();
  const double p1 = k[2], p2 = k[3];
  const double s = p.squaredNorm();
  const double numerator = 1 + s * (k[0] + s * (k[1] + s * k[4]));
  const double denominator = 1 + s * (k[5] + s * (k[6] + s * k[7]));
  const double q = numerator / denominator;
  if (jacobian != nullptr) {
    const double numerator_ds = k[0] + s * (2 * k[1] + s * 3 * k[4]);
    const double denominator_ds = k[5] + s * (2 * k[6] + s * 3 * k[7]);
    const double q_ds = (numerator_ds - q * denominator_ds) / denominator;
    const double cross = 2 * x * y * q_ds + 2 * p1 * x + 2 * p2 * y;
    *jacobian << q + 2 * x * x * q_ds + 2 * p1 * y + 6 * p2 * x, cross,  //
        cross, q + 2 * y * y * q_ds + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * q + 2 * p1 * x * y + p2 * (s + 2 * x * x), y * q + p1 * (s + 2 * y * y) + 2 * p2 * x * y};
}

Eigen::Vector2d distort_equidistant(const std::array<double, 8>& k, const Eigen::Vector2d& p,
                                    Eigen::Matrix2d* jacobian) noexcept {
  const double r = p.norm();
  double q = 1 + (k[0] - 1.0 / 3) * r * r;    // theta_d / r, to r^4
  double q_dr_over_r = 2 * (k[0] - 1.0 / 3);  // (dq/dr) / r, to r^2
  if (r > 1e-4) {
    const LensValue lens = equidistant_lens(k, std::atan(r));
    q = lens.value / r;
    q_dr_over_r = (lens.slope / (1 + r * r) - q) / (r * r);
  }
  if (jacobian != nullptr) *jacobian = q * Eigen::Matrix2d::Identity() + q_dr_over_r * p * p.transpose();
  return q * p;
}

}  // namespace

Eigen::Vector2d CameraModel::distort(const Eigen::Vector2d& point, Eigen::Matrix2d* jacobian) const noexcept {
  return model == DistortionModel::kEquidistant ? distort_equidistant(k, point, jacobian)
                                                : distort_polynomial(k, point, jacobian);
}

Eigen::Vector2d CameraModel::pixel_from_normalised(const Eigen::Vector2d& point,
                                                   Eigen::Matrix2d* jacobian) const noexcept {
  const Eigen::Vector2d distorted = distort(point, jacobian);
  if (jacobian != nullptr) {
    jacobian->row(0) *= fx_px;
    jacobian->row(1) *= fy_px;
  }
  return {fx_px * distorted.x() + cx_px, fy_px * distorted.y() + cy_px};
}

Result<Eigen::Vector2d> CameraModel::normalised_from_pixel(const Eigen::Vector2d& pixel_px) const noexcept {
  constexpr const char* kOutside = "a pixel lies outside the field in which the lens model has an inverse";
  const Eigen::Vector2d target((pixel_px.x() - cx_px) / fx_px, (pixel_px.y() - cy_px) / fy_px);
  if (!target.allFinite()) return fail(Errc::kPoseDegenerate, kOutside);
  if (!has_distortion()) return target;

  const double radius = target.norm();
  if (radius == 0 && model == DistortionModel::kEquidistant) return Eigen::Vector2d(0, 0);
  if (model == DistortionModel::kEquidistant) {
    const auto lens = [this](double theta_rad) noexcept { return equidistant_lens(k, theta_rad); };
    const double theta_rad = invert_lens(lens, radius, kMaxEquidistantTheta_rad);
    if (theta_rad < 0) return fail(Errc::kPoseDegenerate, kOutside);
    return Eigen::Vector2d(target * (std::tan(theta_rad) / radius));
  }

  const auto lens = [this](double r) noexcept { return polynomial_lens(k, r); };
  const double start = invert_lens(lens, radius, std::numeric_limits<double>::infinity());
  if (start < 0) return fail(Errc::kPoseDegenerate, kOutside);
  Eigen::Vector2d point = radius > 0 ? Eigen::Vector2d(target * (start / radius)) : Eigen::Vector2d(0, 0);
  for (int step = 0; step < kMaxPlaneSteps; ++step) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d residual = distort(point, &jacobian) - target;
    const double determinant = jacobian.determinant();
    if (!(determinant > 0)) break;
    if (residual.norm() < 1e-15 * (1 + radius)) break;
    const Eigen::Vector2d change = jacobian.inverse() * residual;
    point -= change;
    if (change.norm() < 1e-15 * (1 + point.norm())) break;
  }
  Eigen::Matrix2d jacobian;
  const double residual = (distort(point, &jacobian) - target).norm();
  if (!(residual < kResidualLimit && jacobian.determinant() > 0 && rises_up_to(lens, point.norm())))
    return fail(Errc::kPoseDegenerate, kOutside);
  return point;
}

}  // namespace ninedot
