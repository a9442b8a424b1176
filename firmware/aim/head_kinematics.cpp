// A direction is brought to the middle in closed form. A point beside axes that do not meet is brought there by doing
// so again from where that led: each time the camera is nearer to where it will be, and the rest of the error is the
// last one times (offset of the axes) / (distance).
#include "aim/head_kinematics.h"

#include <algorithm>
#include <cmath>

#include "geometry/euler_angles.h"

namespace ninedot {
namespace {

// Eight rounds leave 1e-5 rad of an offset of a quarter of the distance, nearer than any landmark is seen whole.
constexpr int kMostRounds = 8;
constexpr double kSettled_rad = 1e-9;

Eigen::Matrix3d forward_left_up_from_optical() noexcept {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

Eigen::Vector3d turned(const Eigen::Vector3d& v, const HeadAngles& head) noexcept {
  const double ct = std::cos(head.tilt_rad), st = std::sin(head.tilt_rad);
  const double cp = std::cos(head.pan_rad), sp = std::sin(head.pan_rad);
  const double forward = ct * v.x() - st * v.z();
  return {cp * forward - sp * v.y(), sp * forward + cp * v.y(), st * v.x() + ct * v.z()};
}

double half_turn(double angle_rad) noexcept { return std::atan2(std::sin(angle_rad), std::cos(angle_rad)); }

/// Both directions in the axes of the tilted head.
HeadAngles angles_between(const Eigen::Vector3d& target_tilted, const Eigen::Vector3d& centre,
                          const HeadAngles& head) noexcept {
  const Eigen::Vector3d target = turned(target_tilted.normalized(), head);
  // Height: centre.x sin(tilt) + centre.z cos(tilt) = target.z; then the remaining turn is about the vertical.
  const double reach = std::hypot(centre.x(), centre.z());
  HeadAngles goal;
  goal.tilt_rad = std::asin(std::clamp(target.z() / reach, -1.0, 1.0)) - std::atan2(centre.z(), centre.x());
  const double forward = centre.x() * std::cos(goal.tilt_rad) - centre.z() * std::sin(goal.tilt_rad);
  const double pan_rad = std::atan2(target.y(), target.x()) - std::atan2(centre.y(), forward);
  goal.pan_rad = head.pan_rad + half_turn(pan_rad - head.pan_rad);
  return goal;
}

}  // namespace

HeadAngles angles_towards(const Eigen::Vector3d& target_camera, const Eigen::Vector3d& centre_camera,
                          const HeadAngles& head) noexcept {
  const Eigen::Matrix3d R = forward_left_up_from_optical();
  return angles_between(R * target_camera, (R * centre_camera).normalized(), head);
}

HeadKinematics::HeadKinematics(const CameraModel& camera, const BodyGeometry& body) noexcept
    : tilt_axis_m_(body.tilt_axis_m),
      camera_m_(body.camera_m),
      tilted_from_camera_(
          rotation_of(YawPitchRoll{body.camera_rpy_rad.z(), body.camera_rpy_rad.y(), body.camera_rpy_rad.x()}) *
          forward_left_up_from_optical()),
      centre_camera_(0, 0, 1) {
  const double right = camera.width_px - 1, bottom = camera.height_px - 1;
  const auto ray_of = [&](double u_px, double v_px, const Eigen::Vector3d& otherwise) -> Eigen::Vector3d {
    const auto seen = camera.normalised_from_pixel({u_px, v_px});
    return seen ? seen->homogeneous().normalized() : otherwise;
  };
  centre_camera_ = ray_of(right / 2, bottom / 2, {0, 0, 1});
  // Where the lens model has no inverse the picture's edge is taken as of a lens without distortion.
  const auto angle_to = [&](double u_px, double v_px) {
    const Eigen::Vector3d plain((u_px - camera.cx_px) / camera.fx_px, (v_px - camera.cy_px) / camera.fy_px, 1);
    return std::acos(std::clamp(centre_camera_.dot(ray_of(u_px, v_px, plain.normalized())), -1.0, 1.0));
  };
  half_width_rad_ = std::min(angle_to(0, bottom / 2), angle_to(right, bottom / 2));
  half_height_rad_ = std::min(angle_to(right / 2, 0), angle_to(right / 2, bottom));
}

Eigen::Vector3d HeadKinematics::in_tilted(const Eigen::Vector3d& point_camera_m) const noexcept {
  return tilted_from_camera_ * point_camera_m + camera_m_;
}

Eigen::Vector3d HeadKinematics::in_base(const Eigen::Vector3d& point_camera_m, const HeadAngles& head) const noexcept {
  return turned(in_tilted(point_camera_m), head) + turned(tilt_axis_m_, {head.pan_rad, 0});
}

/// From the optical centre, in the axes of the tilted head.
Eigen::Vector3d HeadKinematics::from_base(const Eigen::Vector3d& point_base_m, const HeadAngles& head) const noexcept {
  const Eigen::Vector3d panned = turned(point_base_m, {-head.pan_rad, 0}) - tilt_axis_m_;
  return turned(panned, {0, -head.tilt_rad}) - camera_m_;
}

HeadAngles HeadKinematics::towards(const Eigen::Vector3d& point_base_m, const HeadAngles& near) const noexcept {
  const Eigen::Vector3d centre = tilted_from_camera_ * centre_camera_;
  HeadAngles head = near;
  for (int round = 0; round < kMostRounds; ++round) {
    const HeadAngles before = head;
    const Eigen::Vector3d seen = from_base(point_base_m, head);
    if (!(seen.squaredNorm() > 0)) break;
    head = angles_between(seen, centre, head);
    if (std::abs(head.pan_rad - before.pan_rad) + std::abs(head.tilt_rad - before.tilt_rad) < kSettled_rad) break;
  }
  head.pan_rad = near.pan_rad + half_turn(head.pan_rad - near.pan_rad);
  return head;
}

double HeadKinematics::off_centre_rad(const Eigen::Vector3d& point_camera_m) const noexcept {
  return std::atan2(centre_camera_.cross(point_camera_m).norm(), centre_camera_.dot(point_camera_m));
}

}  // namespace ninedot
