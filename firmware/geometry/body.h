#pragma once
/// From the camera to the robot that carries it: where it is mounted, and the two axes of its head.
///
/// Frame body: x forward, y left, z up (as REP 103 of ROS has it). Pan is positive to the left, tilt positive upwards,
/// both zero straight ahead; panning turns the tilt axis with it.
///
///     T_body_camera = mount . Rz(pan) . tilt axis . Ry(-tilt) . camera . misalignment . optical
///
/// `optical` turns x right, y down, z forward into x forward, y left, z up.
#include <Eigen/Core>

#include "base/head_angles.h"
#include "geometry/transform.h"

namespace ninedot {

using BodyFromCamera = Transform<frame::Body, frame::Camera>;
using WorldFromBody = Transform<frame::World, frame::Body>;
/// Of a pose: (position [m, axes of the frame that it is in], rotation vector [rad, own axes]): p + position,
/// R exp(rotation). [m^2, m rad, rad^2]
using BodyCovariance = Eigen::Matrix<double, 6, 6>;

/// All zero: the camera's optical centre is the body's origin, and it looks along x. Angles (roll, pitch, yaw) turn by
/// Rz(yaw) Ry(pitch) Rx(roll): a positive pitch looks down.
struct BodyGeometry {
  Eigen::Vector3d pan_axis_m = Eigen::Vector3d::Zero();      ///< a point of the pan axis, in the body
  Eigen::Vector3d mount_rpy_rad = Eigen::Vector3d::Zero();   ///< of the head's foot against the body
  Eigen::Vector3d tilt_axis_m = Eigen::Vector3d::Zero();     ///< a point of the tilt axis from it, turning with pan
  Eigen::Vector3d camera_m = Eigen::Vector3d::Zero();        ///< the optical centre from that, turning with both
  Eigen::Vector3d camera_rpy_rad = Eigen::Vector3d::Zero();  ///< small: how the camera sits askew on its head
  double pan_sigma_rad = 0, tilt_sigma_rad = 0;   ///< 1-sigma of the angles that the head tells: encoder, dead band
  double mount_sigma_m = 0, mount_sigma_rad = 0;  ///< 1-sigma of the camera's place on the body, each axis
};

struct CameraOnBody {
  BodyFromCamera T_body_camera;
  BodyCovariance covariance = BodyCovariance::Zero();  ///< [m^2, m rad, rad^2]
};

/// \param head  zero for a camera without one
/// Memory: none. Threads: pure.
CameraOnBody camera_on_body(const BodyGeometry& body, const HeadAngles& head) noexcept;

struct BodyPose {
  WorldFromBody T_world_body;
  BodyCovariance covariance = BodyCovariance::Zero();  ///< [m^2, m rad, rad^2]
};

/// T_world_body = T_world_camera T_camera_body; the errors of both are taken as independent, to first order.
/// \param camera_covariance  of T_world_camera [m^2, m rad, rad^2]
/// Memory: none. Threads: pure.
BodyPose body_in_world(const Transform<frame::World, frame::Camera>& T_world_camera,
                       const BodyCovariance& camera_covariance, const CameraOnBody& camera) noexcept;

}  // namespace ninedot
