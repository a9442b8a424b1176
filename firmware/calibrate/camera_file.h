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
#include <string>
#include <string_view>

#include "geometry/camera_model.h"

namespace ninedot {

/// Reads and checks the text of a calibration file. \param name  how errors call the file
/// Throws StartupError(kWrongUsage), "NAME:LINE: what is wrong".
CameraModel parse_camera(std::string_view text, const std::string& name);

/// The text of a calibration file that reads back to exactly the same model.
std::string format_camera(const CameraModel& camera, const std::string& camera_name);

}  // namespace ninedot
