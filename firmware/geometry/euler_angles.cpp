#include "geometry/euler_angles.h"

#include <cmath>

namespace ninedot {
namespace {

/// cos(pitch) of a matrix in double precision this near to the pole is rounding, and so are yaw and roll.
constexpr double kLocked = 1e-7;

}  // namespace

Eigen::Matrix3d rotation_of(const YawPitchRoll& angles) noexcept {
  const double sy = std::sin(angles.yaw_rad), cy = std::cos(angles.yaw_rad);
  const double sp = std::sin(angles.pitch_rad), cp = std::cos(angles.pitch_rad);
  const double sr = std::sin(angles.roll_rad), cr = std::cos(angles.roll_rad);
  Eigen::Matrix3d R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return R;
}

Eigen::Matrix3d rotation_of(const FanucAngles& angles) noexcept {
  return rotation_of(YawPitchRoll{angles.r_rad, angles.p_rad, angles.w_rad});
}

Eigen::Matrix3d rotation_of(const KukaAngles& angles) noexcept {
  return rotation_of(YawPitchRoll{angles.a_rad, angles.b_rad, angles.c_rad});
}

YawPitchRoll yaw_pitch_roll(const Eigen::Matrix3d& R) noexcept {
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  const double pitch_rad = std::atan2(-R(2, 0), cos_pitch);
  if (cos_pitch < kLocked) return {std::atan2(-R(0, 1), R(1, 1)), pitch_rad, 0};
  return {std::atan2(R(1, 0), R(0, 0)), pitch_rad, std::atan2(R(2, 1), R(2, 2))};
}

FanucAngles fanuc_angles(const Eigen::Matrix3d& R) noexcept {
  const YawPitchRoll angles = yaw_pitch_roll(R);
  return {angles.roll_rad, angles.pitch_rad, angles.yaw_rad};
}

KukaAngles kuka_angles(const Eigen::Matrix3d& R) noexcept {
  const YawPitchRoll angles = yaw_pitch_roll(R);
  return {angles.yaw_rad, angles.pitch_rad, angles.roll_rad};
}

Eigen::Matrix3d covariance_of_angles(const YawPitchRoll& angles, const Eigen::Matrix3d& rotation_covariance) noexcept {
  const double sr = std::sin(angles.roll_rad), cr = std::cos(angles.roll_rad);
  const double cp = std::cos(angles.pitch_rad), tp = std::tan(angles.pitch_rad);
  Eigen::Matrix3d J;
  J << 0, sr / cp, cr / cp, 0, cr, -sr, 1, sr * tp, cr * tp;
  return J * rotation_covariance * J.transpose();
}

}  // namespace ninedot
