#include "drivers/simulation/ray_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ninedot {
namespace {

/// "Camera Calibration and 3D Reconstruction" of OpenCV's documentation; equidistant: Kannala & Brandt, PAMI 2006.
Eigen::Vector2d distorted(const CameraModel& camera, const Eigen::Vector2d& point) noexcept {
  const auto& k = camera.k;
  if (camera.model == DistortionModel::kEquidistant) {
    const double r = point.norm();
    if (r < 1e-9) return point;
    const double angle = std::atan(r), square = angle * angle;
    const double bent = angle * (1 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))));
    return point * (bent / r);
  }
  const double x = point.x(), y = point.y(), square = point.squaredNorm();
  double radial = 1 + square * (k[0] + square * (k[1] + square * k[4]));
  if (camera.model == DistortionModel::kRationalPolynomial)
    radial /= 1 + square * (k[5] + square * (k[6] + square * k[7]));
  return {x * radial + 2 * k[2] * x * y + k[3] * (square + 2 * x * x),
          y * radial + k[2] * (square + 2 * y * y) + 2 * k[3] * x * y};
}

/// Newton's method with differences. \return  not a number where it does not end
Eigen::Vector2d undistorted(const CameraModel& camera, const Eigen::Vector2d& seen, Eigen::Vector2d start) noexcept {
  constexpr double kStep = 1e-6, kSettled = 1e-12;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d left_over = seen - distorted(camera, start);
    if (left_over.norm() < kSettled) return start;
    Eigen::Matrix2d J;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      J.col(axis) = (distorted(camera, start + step) - distorted(camera, start - step)) / (2 * kStep);
    }
    const double determinant = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    if (!(determinant > 1e-3)) break;  // the picture folds over: beyond the lens's field
    start += Eigen::Vector2d(J(1, 1) * left_over.x() - J(0, 1) * left_over.y(),
                             J(0, 0) * left_over.y() - J(1, 0) * left_over.x()) /
             determinant;
  }
  return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector2d& point) noexcept {
  const Eigen::Vector2d seen = distorted(camera, point);
  return {camera.fx_px * seen.x() + camera.cx_px, camera.fy_px * seen.y() + camera.cy_px};
}

RayField::RayField(const CameraModel& camera) : width_px_(camera.width_px), height_px_(camera.height_px) {
  rays_.reserve(static_cast<std::size_t>(width_px_ + 2 * kBorder_px) *
                static_cast<std::size_t>(height_px_ + 2 * kBorder_px));
  for (int v = -kBorder_px; v < height_px_ + kBorder_px; ++v)
    for (int u = -kBorder_px; u < width_px_ + kBorder_px; ++u) {
      const Eigen::Vector2d seen((u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px);
      const Eigen::Vector2d ray = undistorted(camera, seen, seen);
      rays_.push_back({static_cast<float>(ray.x()), static_cast<float>(ray.y())});
      if (std::isfinite(ray.x())) farthest_ = std::max(farthest_, ray.norm());
    }
}

}  // namespace ninedot
