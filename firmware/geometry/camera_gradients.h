#pragma once
/// How a pixel and its ray change with the camera's own parameters: for calibrations, and for the share that a
/// calibration's uncertainty has in a pose.
#include <Eigen/Core>

#include "geometry/camera_model.h"

namespace ninedot {

/// Order: fx, fy, cx, cy [px], then CameraModel::k in its own order [1]. Coefficients that a model does not have: 0.
inline constexpr int kIntrinsics = 12;
using IntrinsicGradient = Eigen::Matrix<double, 2, kIntrinsics>;
/// Of the intrinsics in this order. [px^2, px, 1]
using IntrinsicCovariance = Eigen::Matrix<double, kIntrinsics, kIntrinsics>;

/// d(pixel)/d(intrinsics) of a normalised point that stays. \param point  z = 1, distortion removed
/// \return  [px] per unit of each intrinsic. Memory: none. Threads: pure.
IntrinsicGradient pixel_by_intrinsics(const CameraModel& camera, const Eigen::Vector2d& point) noexcept;

/// d(ray)/d(intrinsics) of a pixel that stays: the ray, z = 1, at which the pixel looks now.
/// \param point  z = 1: of the pixel, where the model has an inverse
/// \return  at z = 1, per unit of each intrinsic. Memory: none. Threads: pure.
IntrinsicGradient ray_by_intrinsics(const CameraModel& camera, const Eigen::Vector2d& point) noexcept;

}  // namespace ninedot
