#pragma once
/// Writes calibration files: ROS camera_info, with comments for people, and beside it how well the lens is known.
///
///     calibration:                  # other programs pass over it
///       date: "2026-11-22"          # UTC
///       camera_id: ""               # what the camera calls itself; empty: unknown
///       lens: ""
///       views: 60
///       rms_px: 0.04
///       direction_sigma_px: 0.012   # median over the picture of the expected error of a pixel's direction
///       direction_sigma_max_px: 0.05
///       covariance: {rows: 9, cols: 9, data: [...]}   # fx, fy, cx, cy, then the coefficients; px and 1; by rows
#include <Eigen/Core>
#include <string>
#include <vector>

#include "geometry/camera_model.h"

namespace ninedot {

/// What a calibration found out beside the model itself.
struct CalibrationNotes {
  std::string date;       ///< UTC day, YYYY-MM-DD
  std::string camera_id;  ///< empty: unknown
  std::string lens;       ///< what a person calls it; may be empty
  std::size_t views = 0;
  double rms_px = 0;                  ///< of the residuals
  double direction_sigma_px = 0;      ///< 1-sigma of a pixel's direction, median over the picture
  double direction_sigma_max_px = 0;  ///< largest
  Eigen::MatrixXd covariance;         ///< of fx, fy, cx, cy [px] and the model's coefficients [1], in the file's order
  std::vector<std::string> comments;  ///< lines for people at the file's beginning, without '#'
};

/// "covariance:" with its rows, a key of a mapping. \param covariance  [px^2, px, 1] \param indent  of the key
std::string format_covariance(const Eigen::MatrixXd& covariance, const std::string& indent);

/// The text of a calibration file; parse_camera reads the same model back, to the last bit.
/// \param camera_name  as ROS has it
std::string format_calibrated_camera(const CameraModel& camera, const std::string& camera_name,
                                     const CalibrationNotes& notes);

}  // namespace ninedot
