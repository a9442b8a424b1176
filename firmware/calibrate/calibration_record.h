#pragma once
/// What a calibration file says of itself beside the camera's numbers: of which camera it is, and how good.
#include <optional>
#include <string>

#include "geometry/camera_gradients.h"

namespace ninedot {

/// Whatever is not there is unknown: empty, or without a value.
struct CalibrationRecord {
  std::string date;                              ///< `date`: UTC day, "2026-11-22"
  std::string camera_id;                         ///< `camera_id`: see is_same_camera
  std::string lens;                              ///< `lens`: for people
  std::optional<int> views;                      ///< `views`: pictures that it was made of [1]
  std::optional<double> rms_px;                  ///< `rms_px`: residual
  std::optional<double> direction_sigma_px;      ///< `direction_sigma_px`: expected error of a direction, median
  std::optional<double> direction_sigma_max_px;  ///< `direction_sigma_max_px`: likewise, the worst of the picture
  /// `covariance` [px, 1]: coefficients beyond the file's 0.
  std::optional<IntrinsicCovariance> covariance;
};

}  // namespace ninedot
