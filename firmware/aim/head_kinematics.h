#pragma once
/// The head's two axes and the camera on them: where a point that the camera sees lies from the head's foot, and at
/// which angles it comes to the middle of the picture.
///
/// Frame base: the head's foot, its origin on the pan axis; x forward, y left, z up. How the foot stands on the robot
/// does not matter here. T_base_camera = Rz(pan) . tilt axis . Ry(-tilt) . camera . misalignment . optical, as
/// geometry/body.h has it.
#include <Eigen/Core>

#include "base/head_angles.h"
#include "geometry/body.h"
#include "geometry/camera_model.h"

namespace ninedot {

/// The head's angles at which the direction `target_camera`, seen while the head stood at `head`, coincides with the
/// camera's own direction `centre_camera`. Exact for a head whose two axes meet in the optical centre, or for a target
/// that is far compared with their distance.
/// \param target_camera, centre_camera  frame camera, any length > 0, centre_camera within 90 deg of the optical axis
/// \return  pan within half a turn of where the head stood
/// Memory: none. Threads: pure.
HeadAngles angles_towards(const Eigen::Vector3d& target_camera, const Eigen::Vector3d& centre_camera,
                          const HeadAngles& head) noexcept;

/// Memory: inside. Threads: never changed after construction, so any may call anything; nothing waits.
class HeadKinematics {
 public:
  /// \param body  its offsets and the camera's misalignment count, its foot and its sigmas do not
  HeadKinematics(const CameraModel& camera, const BodyGeometry& body) noexcept;

  /// The point in the base [m]. \param head  where the head stood
  Eigen::Vector3d in_base(const Eigen::Vector3d& point_camera_m, const HeadAngles& head) const noexcept;

  /// The angles at which the point is in the middle of the picture; as near as can be for one that never is (between
  /// the axes). \param near  where to begin: pan is within half a turn of it
  HeadAngles towards(const Eigen::Vector3d& point_base_m, const HeadAngles& near) const noexcept;

  /// How far the point is from the middle of the picture [rad], 0..pi.
  double off_centre_rad(const Eigen::Vector3d& point_camera_m) const noexcept;

  /// How much of the surroundings one picture shows beside its middle, in a row and in a column [rad]: the lesser side.
  double half_width_rad() const noexcept { return half_width_rad_; }
  double half_height_rad() const noexcept { return half_height_rad_; }

 private:
  Eigen::Vector3d in_tilted(const Eigen::Vector3d& point_camera_m) const noexcept;
  Eigen::Vector3d from_base(const Eigen::Vector3d& point_base_m, const HeadAngles& head) const noexcept;

  Eigen::Vector3d tilt_axis_m_, camera_m_;
  Eigen::Matrix3d tilted_from_camera_;  // camera axes in those of the tilted head, x forward
  Eigen::Vector3d centre_camera_;       // the direction of the picture's middle
  double half_width_rad_ = 0, half_height_rad_ = 0;
};

}  // namespace ninedot
