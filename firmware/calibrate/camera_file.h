#pragma once
/// Camera calibration files: the YAML forms of ROS camera_info (camera_calibration) and of OpenCV's FileStorage.
///
///     image_width: 640
///     image_height: 480
///     camera_matrix: {rows: 3, cols: 3, data: [fx, 0, cx, 0, fy, cy, 0, 0, 1]}   # px; pixel centres at integers
///     distortion_model: plumb_bob               # plumb_bob | rational_polynomial | equidistant
///     distortion_coefficients: {rows: 1, cols: 5, data: [k1, k2, p1, p2, k3]}
///
/// Without distortion_model the number of coefficients tells: none, 4 or 5 plumb_bob, 8 rational_polynomial. OpenCV's
/// `fisheye_model: 1` stands for equidistant. Other keys belong to other programs and are not read.
///
/// A mapping that other programs leave alone says where the numbers come from and how good they are (every key may be
/// missing, and so may the mapping; keys of later versions are not read):
///
///     calibration:
///       date: "2026-11-22"            # UTC day
///       camera_id: "usb-046d:0825-1A2B3C"   # what the service asks the device for; empty: unknown
///       lens: "6 mm f/2.0"
///       views: 60
///       rms_px: 0.04                  # residual
///       direction_sigma_px: 0.012     # median over the picture of the expected error of a pixel's direction
///       direction_sigma_max_px: 0.05
///       covariance:                   # of fx, fy, cx, cy and the coefficients in their order in the file [px, 1]
///         rows: 9
///         cols: 9
///         data: [...]
///
/// A further one, `zoom`, is that of a zoom camera (zoom_file.h).
#include <optional>
#include <string>
#include <string_view>

#include "calibrate/calibration_record.h"
#include "calibrate/zoom_table.h"
#include "geometry/camera_model.h"

namespace ninedot {

struct CameraCalibration {
  CameraModel camera;
  CalibrationRecord record;
  std::optional<ZoomTable> zoom = {};  ///< of a zoom camera; `camera` is then the lens of one position
};

/// Reads and checks the text of a calibration file. \param name  how errors call the file
/// Throws StartupError(kWrongUsage), "NAME:LINE: what is wrong".
CameraCalibration parse_calibration(std::string_view text, const std::string& name);

/// The camera of it alone; the rest is checked all the same.
CameraModel parse_camera(std::string_view text, const std::string& name);

/// The text of a calibration file that reads back to exactly the same model.
std::string format_camera(const CameraModel& camera, const std::string& camera_name);

}  // namespace ninedot
