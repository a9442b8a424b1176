#include "geometry/renumbered.h"

#include <cmath>
#include <numbers>

namespace ninedot {

Eigen::Matrix3d R_renumbered_sheet(int eighths) noexcept {
  const double turn_rad = eighths * std::numbers::pi / 4;
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  // The new X is cos X + sin Z, the new Z cos Z - sin X, Y stays.
  Eigen::Matrix3d R;
  R << c, 0, s, 0, 1, 0, -s, 0, c;
  return R;
}

CameraFromLandmark renumbered(const CameraFromLandmark& T_camera_landmark, int eighths) noexcept {
  return {T_camera_landmark.rotation * R_renumbered_sheet(eighths).transpose(), T_camera_landmark.translation_m};
}

}  // namespace ninedot
