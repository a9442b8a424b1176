#pragma once
/// Where the robot is, and where the camera on its head then is.
#include <Eigen/Geometry>
#include <vector>

#include "base/head_angles.h"

namespace ninedot {

struct WayPoint {
  double t_s = 0;                                        ///< since the start of the simulation
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of the body's origin, frame world (Z up)
  double heading_rad = 0;                                ///< of the body's x axis about the world's Z
};

/// Straight lines between the way-points, each at an even speed; before the first and after the last it stands there.
/// Headings are interpolated as the numbers that they are.
/// \param path  at least one, by rising time (contract)
/// Memory: none. Threads: pure.
WayPoint place_on(const std::vector<WayPoint>& path, double t_s) noexcept;

/// Where the head sits on the body (x forward, y left, z up) and the camera on the head. Angles are (roll, pitch, yaw)
/// about x, then y, then z; a positive pitch looks down. All zero: the axes meet in the body's origin, and there the
/// optical centre is.
struct HeadMount {
  Eigen::Vector3d pan_axis_m = Eigen::Vector3d::Zero();      ///< a point of the pan axis, in the body
  Eigen::Vector3d mount_rpy_rad = Eigen::Vector3d::Zero();   ///< of the head's foot
  Eigen::Vector3d tilt_axis_m = Eigen::Vector3d::Zero();     ///< a point of the tilt axis from there, at pan 0
  Eigen::Vector3d camera_m = Eigen::Vector3d::Zero();        ///< the optical centre from there, at pan and tilt 0
  Eigen::Vector3d camera_rpy_rad = Eigen::Vector3d::Zero();  ///< of the camera on its head
};

/// Maps points of the camera (x right, y down, z forward) into the world. Memory: none. Threads: pure.
Eigen::Isometry3d world_from_camera(const WayPoint& body, const HeadMount& mount, const HeadAngles& head) noexcept;

}  // namespace ninedot
