#pragma once
/// A lens's parameters as the calibration counts them: fx, fy, cx, cy [px], then the coefficients that its model has.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "geometry/camera_model.h"

namespace ninedot {

inline constexpr int kPlainIntrinsics = 4;  ///< fx, fy, cx, cy

constexpr int coefficient_count(DistortionModel model) noexcept {
  if (model == DistortionModel::kRationalPolynomial) return 8;
  return model == DistortionModel::kEquidistant ? 4 : 5;
}
constexpr int parameter_count(DistortionModel model) noexcept { return kPlainIntrinsics + coefficient_count(model); }

/// \return  [px] and [1], in that order
inline Eigen::VectorXd parameters_of(const CameraModel& camera) {
  Eigen::VectorXd values(parameter_count(camera.model));
  values.head<kPlainIntrinsics>() << camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px;
  for (int i = 0; i < coefficient_count(camera.model); ++i)
    values(kPlainIntrinsics + i) = camera.k[static_cast<std::size_t>(i)];
  return values;
}

/// \param values  as parameters_of gives them [px], [1]
inline CameraModel with_parameters(CameraModel camera, const Eigen::Ref<const Eigen::VectorXd>& values) {
  camera.fx_px = values(0), camera.fy_px = values(1), camera.cx_px = values(2), camera.cy_px = values(3);
  camera.k = {};
  for (int i = 0; i < coefficient_count(camera.model); ++i)
    camera.k[static_cast<std::size_t>(i)] = values(kPlainIntrinsics + i);
  return camera;
}

/// The picture's corners from its principal point, at f = 1: how far out coefficients have a meaning. [1]
inline double corner_radius(const CameraModel& camera) noexcept {
  const double x = std::max(camera.cx_px, camera.width_px - camera.cx_px) / camera.fx_px;
  const double y = std::max(camera.cy_px, camera.height_px - camera.cy_px) / camera.fy_px;
  return std::hypot(x, y);
}

}  // namespace ninedot
