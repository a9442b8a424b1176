#pragma once
/// The same camera before the same sheet when another dot of the ring is called P1.
#include "geometry/transform.h"

namespace ninedot {

/// \param eighths  the dot at index `eighths` becomes P1; any integer [1]
/// Memory: none. Threads: pure.
CameraFromLandmark renumbered(const CameraFromLandmark& T_camera_landmark, int eighths) noexcept;

/// Turns vectors of the sheet's frame into that of the renumbered one. \param eighths  as above [1]
/// \return  rotation matrix [1]
Eigen::Matrix3d R_renumbered_sheet(int eighths) noexcept;

}  // namespace ninedot
