#pragma once
/// Between a pose and the founding paper's parameters psi, phi, theta, D, D', delta (Martin & Adan, Pattern Recognition
/// 45 (2012) 578-595): both directions, exact.
#include <Eigen/Core>
#include <numbers>

#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "pose/estimate.h"

namespace ninedot {

/// f in D' = D + f (4) where the lens's focal length in millimetres is not configured: a calibrated camera knows f in
/// pixels only, and with Kmm = 1 / fx it is 1 mm.
inline constexpr double kUnitFocalLength_m = 0.001;

/// The parameters of a pose.
/// All angles are those of the picture that the camera would take if it were turned, by the shortest way, until P9 is
/// in the middle of the picture, as the paper assumes.
/// - swing psi in (-pi/2, pi/2]: of the ring ellipse's major axis, from upwards towards the right;
/// - tilt phi in [0, pi/2): between the line of sight to P9 and the sheet's normal;
/// - pan theta in (-pi, pi]: the camera's optical centre is D (sin phi cos theta, cos phi, -sin phi sin theta) in S0;
/// - deviation delta in [0, pi): between the optical axis and the direction to P9.
/// Frontal views (phi = 0) leave theta open: it is 0 there, and psi is the roll.
/// Memory: none. Threads: pure.
EllipseParameters ellipse_parameters(const Transform<frame::Landmark, frame::Camera>& T_landmark_camera,
                                     const CameraModel& camera, const LandmarkGeometry& landmark,
                                     double focal_length_m = kUnitFocalLength_m) noexcept;

/// The pose of the parameters; the inverse of `ellipse_parameters`.
/// \param oriented_swing_rad  psi, or psi + pi: the direction of the major axis along which P5 lies where theta = 0
/// \param p9_normalised  where P9 is seen, z = 1
Transform<frame::Landmark, frame::Camera> pose_from_parameters(double oriented_swing_rad, double tilt_phi_rad,
                                                               double pan_theta_rad, double distance_m,
                                                               const Eigen::Vector2d& p9_normalised) noexcept;

/// The shortest rotation that turns the direction (point, 1) into the optical axis. \param point_normalised  z = 1
/// \return  a rotation matrix
Eigen::Matrix3d centring_rotation(const Eigen::Vector2d& point_normalised) noexcept;

/// tan(delta) = m / f (27), m the distance of P9 from the middle of the picture.
/// \param p9_normalised  where P9 is seen, z = 1
double deviation_rad(const Eigen::Vector2d& p9_normalised) noexcept;

/// gamma = pi/2 - (phi - delta) (28): heading of the camera from X0 where sheet and camera stand at the same height.
/// \param deviation_rad  positive where the camera is turned towards the sheet's normal
inline double heading_gamma_rad(double tilt_phi_rad, double deviation_rad) noexcept {
  return std::numbers::pi / 2 - (tilt_phi_rad - deviation_rad);
}

/// 1 - cos(delta) (30): the share of the distance by which (3) errs where the picture is not centred.
double misalignment_distance_error(double deviation_rad) noexcept;

}  // namespace ninedot
