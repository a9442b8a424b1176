#pragma once
/// How a camera moves, and the sheets before it by that.
#include <optional>

#include "geometry/sheet_motion.h"
#include "track/pose_filter.h"

namespace ninedot {

/// In the camera's own axes.
struct CameraTwist {
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  double rate_sigma_rad_s = 0;  ///< of the angular velocity, 1-sigma over all axes

  /// How a sheet that hangs still moves before it then; rows all at once. \param t_camera_m  the sheet's origin
  SheetMotion of_sheet_at(const Eigen::Vector3d& t_camera_m) const noexcept {
    return {-angular_velocity_rad_s, -angular_velocity_rad_s.cross(t_camera_m) - velocity_m_s};
  }
};

/// Of a tracked camera.
inline CameraTwist twist_of(const TrackedPose& tracked) noexcept {
  return {tracked.motion.angular_velocity_rad_s,
          tracked.motion.T_world_camera.rotation.transpose() * tracked.motion.velocity_m_s,
          std::sqrt(tracked.covariance.diagonal().tail<3>().sum())};
}

}  // namespace ninedot
