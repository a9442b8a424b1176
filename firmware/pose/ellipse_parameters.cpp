/// In the sheet, the ring's diameter along e1 = (sin theta, 0, cos theta) is seen unshortened: it is the ellipse's
/// major axis. The camera leans away from the sheet's normal at a right angle to it.
#include "pose/ellipse_parameters.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ninedot {

Eigen::Matrix3d centring_rotation(const Eigen::Vector2d& point_normalised) noexcept {
  return Eigen::Quaterniond::FromTwoVectors(point_normalised.homogeneous(), Eigen::Vector3d::UnitZ())
      .toRotationMatrix();
}

double deviation_rad(const Eigen::Vector2d& p9_normalised) noexcept { return std::atan(p9_normalised.norm()); }

double misalignment_distance_error(double deviation_rad) noexcept { return 1 - std::cos(deviation_rad); }

EllipseParameters ellipse_parameters(const Transform<frame::Landmark, frame::Camera>& T_landmark_camera,
                                     const CameraModel& /*camera*/, const LandmarkGeometry& /*landmark*/,
                                     double focal_length_m) noexcept {
  const Eigen::Vector3d& position_m = T_landmark_camera.translation_m;
  EllipseParameters parameters;
  parameters.distance_m = position_m.norm();
  parameters.image_distance_m = parameters.distance_m + focal_length_m;
  const double aside_m = std::hypot(position_m.x(), position_m.z());
  parameters.tilt_phi_rad = std::atan2(aside_m, position_m.y());
  constexpr double kFrontal = 1e-12;  // share of the distance below which the azimuth is rounding error
  const bool frontal = aside_m < kFrontal * parameters.distance_m;
  parameters.pan_theta_rad = frontal ? 0 : std::atan2(-position_m.z(), position_m.x());

  const Eigen::Vector3d to_p9 = T_landmark_camera.rotation.transpose() * -position_m;
  parameters.deviation_rad = std::atan2(to_p9.head<2>().norm(), to_p9.z());
  const Eigen::Matrix3d centring =
      Eigen::Quaterniond::FromTwoVectors(to_p9, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d R_landmark_centred = T_landmark_camera.rotation * centring.transpose();
  const Eigen::Vector3d major(std::sin(parameters.pan_theta_rad), 0, std::cos(parameters.pan_theta_rad));
  double swing_rad = std::atan2(major.dot(R_landmark_centred.col(0)), -major.dot(R_landmark_centred.col(1)));
  if (swing_rad > std::numbers::pi / 2) swing_rad -= std::numbers::pi;
  if (swing_rad <= -std::numbers::pi / 2) swing_rad += std::numbers::pi;
  parameters.swing_psi_rad = swing_rad;
  return parameters;
}

Transform<frame::Landmark, frame::Camera> pose_from_parameters(double oriented_swing_rad, double tilt_phi_rad,
                                                               double pan_theta_rad, double distance_m,
                                                               const Eigen::Vector2d& p9_normalised) noexcept {
  const double sin_theta = std::sin(pan_theta_rad), cos_theta = std::cos(pan_theta_rad);
  const Eigen::Vector3d from_p9(std::sin(tilt_phi_rad) * cos_theta, std::cos(tilt_phi_rad),
                                -std::sin(tilt_phi_rad) * sin_theta);
  const Eigen::Vector3d forward = -from_p9;
  const Eigen::Vector3d major(sin_theta, 0, cos_theta);
  const Eigen::Vector3d minor = forward.cross(major);
  const double c = std::cos(oriented_swing_rad), s = std::sin(oriented_swing_rad);
  Eigen::Matrix3d R_landmark_centred;
  R_landmark_centred << s * major + c * minor, s * minor - c * major, forward;
  return {R_landmark_centred * centring_rotation(p9_normalised), distance_m * from_p9};
}

}  // namespace ninedot
