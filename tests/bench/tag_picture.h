#pragma once
/// AprilTag's own marker in the place of ours, so that the rivals have something to find and their pose is paid for.
#include <cstdint>
#include <vector>

#include "tests/bench/case_folder.h"

namespace ninedot::bench {

/// Side of the sheet, white border included: the size of the sheet that `ninedot pattern` prints.
inline constexpr double kTagSheetSide_m = 0.210;
/// Side of the tag's black square, what AprilTag calls the tag's size: 8 of the sheet's 10 cells.
inline constexpr double kTagSide_m = kTagSheetSide_m * 8 / 10;

/// The picture with a sheet that shows tag36h11 number 0 in the landmark's place and pose: the frame's own paper and
/// ink levels, noise and blur (picture_quality.h), even light and no tone curve, which flatters the rivals' accuracy.
/// \param frame  shows exactly one landmark (contract)
std::vector<std::uint8_t> paste_tag(const CaseFolder& recording, const CaseFrame& frame);

/// Camera in S0 from the pose of the tag in the camera's frame: both libraries have the tag's x to the viewer's right
/// and y down.
Eigen::Vector3d camera_position_m(const Eigen::Matrix3d& R_camera_tag, const Eigen::Vector3d& t_camera_tag_m);

}  // namespace ninedot::bench
