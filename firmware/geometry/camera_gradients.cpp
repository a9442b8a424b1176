#include "geometry/camera_gradients.h"

#include <Eigen/LU>
#include <cmath>

namespace ninedot {
namespace {

using DistortionGradient = Eigen::Matrix<double, 2, 8>;

/// Of x' = x q + 2 p1 x y + p2 (s + 2 x^2) and its twin, q = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6
/// s^3).
DistortionGradient polynomial_by_coefficients(const std::array<double, 8>& k, const Eigen::Vector2d& p) noexcept {
  const double x = p.x(), y = p.y(), s = p.squaredNorm();
  const double numerator = 1 + s * (k[0] + s * (k[1] + s * k[4]));
  const double denominator = 1 + s * (k[5] + s * (k[6] + s * k[7]));
  const Eigen::Vector2d up = p / denominator, down = -p * numerator / (denominator * denominator);
  DistortionGradient J;
  J << up * s, up * s * s, Eigen::Vector2d(2 * x * y, s + 2 * y * y), Eigen::Vector2d(s + 2 * x * x, 2 * x * y),
      up * s * s * s, down * s, down * s * s, down * s * s * s;
  return J;
}

/// Of theta_d = theta (1 + k1 theta^2 + ...) along the direction of the point.
DistortionGradient equidistant_by_coefficients(const Eigen::Vector2d& p) noexcept {
  const double r = p.norm();
  DistortionGradient J = DistortionGradient::Zero();
  if (!(r > 0)) return J;
  const double theta_rad = std::atan(r);
  double power = theta_rad;
  for (int i = 0; i < 4; ++i) {
    power *= theta_rad * theta_rad;
    J.col(i) = p * (power / r);
  }
  return J;
}

}  // namespace

IntrinsicGradient pixel_by_intrinsics(const CameraModel& camera, const Eigen::Vector2d& point) noexcept {
  const Eigen::Vector2d distorted = camera.distort(point);
  const DistortionGradient by_k = camera.model == DistortionModel::kEquidistant
                                      ? equidistant_by_coefficients(point)
                                      : polynomial_by_coefficients(camera.k, point);
  IntrinsicGradient J = IntrinsicGradient::Zero();
  J(0, 0) = distorted.x(), J(1, 1) = distorted.y();
  J(0, 2) = J(1, 3) = 1;
  J.row(0).tail<8>() = camera.fx_px * by_k.row(0);
  J.row(1).tail<8>() = camera.fy_px * by_k.row(1);
  return J;
}

IntrinsicGradient ray_by_intrinsics(const CameraModel& camera, const Eigen::Vector2d& point) noexcept {
  Eigen::Matrix2d px_per_ray;
  camera.pixel_from_normalised(point, &px_per_ray);
  return -px_per_ray.inverse() * pixel_by_intrinsics(camera, point);
}

}  // namespace ninedot
