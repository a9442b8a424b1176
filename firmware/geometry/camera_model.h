#pragma once
/// The camera: intrinsics and lens distortion, in the conventions of ROS camera_info and OpenCV.
#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "base/result.h"

namespace ninedot {

enum class DistortionModel : std::uint8_t {
  kPlumbBob,            ///< k1 k2 p1 p2 k3 (OpenCV documentation, "Camera Calibration and 3D Reconstruction")
  kRationalPolynomial,  ///< k1 k2 p1 p2 k3 k4 k5 k6 (the same page)
  kEquidistant,         ///< k1 k2 k3 k4: theta_d = theta (1 + k1 theta^2 + ...); Kannala & Brandt, PAMI 2006
};

/// x = Xc/Zc, y = Yc/Zc; (x', y') = distortion of (x, y); u = fx x' + cx, v = fy y' + cy. Pixel centres are integers.
/// Trivially copyable; all functions are pure, allocate nothing and may be called from any thread.
struct CameraModel {
  int width_px = 640;
  int height_px = 480;
  double fx_px = 720, fy_px = 720, cx_px = 319.5, cy_px = 239.5;
  DistortionModel model = DistortionModel::kPlumbBob;
  std::array<double, 8> k{};  ///< coefficients [1] in the model's own order, unused ones 0

  /// Distorts a normalised point.
  /// \param point  at z = 1
  /// \param jacobian  d(distorted)/d(point) [1]; null: not wanted
  /// \return  at z = 1
  Eigen::Vector2d distort(const Eigen::Vector2d& point, Eigen::Matrix2d* jacobian = nullptr) const noexcept;

  /// Pixel of a normalised point.
  /// \param point  at z = 1
  /// \param jacobian  d(pixel)/d(point) [px] per 1 at z = 1; null: not wanted
  /// \return  [px]
  Eigen::Vector2d pixel_from_normalised(const Eigen::Vector2d& point,
                                        Eigen::Matrix2d* jacobian = nullptr) const noexcept;

  /// Normalised point of a pixel: Newton's method on `distort`.
  /// \return  at z = 1
  /// \error kPoseDegenerate: the model has no inverse there (outside the lens's valid field).
  Result<Eigen::Vector2d> normalised_from_pixel(const Eigen::Vector2d& pixel_px) const noexcept;

  bool has_distortion() const noexcept {
    if (model == DistortionModel::kEquidistant) return true;
    for (const double c : k)
      if (c != 0) return true;
    return false;
  }
};

}  // namespace ninedot
