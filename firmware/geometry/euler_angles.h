#pragma once
/// A rotation as three angles, in the conventions of those who read them.
///
/// All of them name one matrix, R = Rz Ry Rx, and differ in names and order only: turns about the axes x, y, z that
/// stay where they are, in this order, are the same as turns about the axes z, y, x that turn along, in that order.
///
/// - Yaw, pitch, roll: of a body with x forward, y left, z up, about z, then the new y, then the new x. A positive
///   pitch is downwards, yaw is positive to the left: the heading.
/// - FANUC W, P, R: turns about the fixed x, y, z of the user frame, in this order: R = Rz(R) Ry(P) Rx(W).
/// - KUKA A, B, C: A about z, then B about the new y, then C about the new x: R = Rz(A) Ry(B) Rx(C).
///
/// As the manual of the rc_visard camera has the two (doc.rc-visard.com, "Pose formats": FANUC XYZ-WPR, KUKA XYZ-ABC).
///
/// Where the pitch is +-90 degrees yaw and roll turn about the same axis and only one sum of them is known: roll is
/// then 0 (gimbal lock). That is so within 1e-7 rad of the pole, where yaw and roll would be noise of the arithmetic.
#include <Eigen/Core>

namespace ninedot {

struct YawPitchRoll {
  double yaw_rad = 0;    ///< -pi..pi, about z
  double pitch_rad = 0;  ///< -pi/2..pi/2, about y
  double roll_rad = 0;   ///< -pi..pi, about x
};

struct FanucAngles {
  double w_rad = 0, p_rad = 0, r_rad = 0;  ///< about the fixed X, Y, Z
};

struct KukaAngles {
  double a_rad = 0, b_rad = 0, c_rad = 0;  ///< about Z, the new Y, the new X
};

/// \return  rotation matrix [1]
Eigen::Matrix3d rotation_of(const YawPitchRoll& angles) noexcept;
Eigen::Matrix3d rotation_of(const FanucAngles& angles) noexcept;  ///< rotation matrix [1]
Eigen::Matrix3d rotation_of(const KukaAngles& angles) noexcept;   ///< rotation matrix [1]

/// \param R  rotation matrix [1]
YawPitchRoll yaw_pitch_roll(const Eigen::Matrix3d& R) noexcept;
FanucAngles fanuc_angles(const Eigen::Matrix3d& R) noexcept;  ///< \param R  rotation matrix [1]
KukaAngles kuka_angles(const Eigen::Matrix3d& R) noexcept;    ///< \param R  rotation matrix [1]

/// Of (yaw, pitch, roll), to first order; without bound towards the pole of the pitch.
/// \param rotation_covariance  of a rotation vector in the turned axes, R exp(rotation) [rad^2] \return  [rad^2]
Eigen::Matrix3d covariance_of_angles(const YawPitchRoll& angles, const Eigen::Matrix3d& rotation_covariance) noexcept;

}  // namespace ninedot
