#pragma once
/// Rigid transforms named by their frames: `T_to_from` maps points of `from` into `to`.
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ninedot {

namespace frame {
struct Camera {};    ///< optical frame: x right, y down, z forward
struct Landmark {};  ///< S0: origin in the middle of P9, X to the viewer's left, Y out of the sheet, Z up
struct World {};     ///< Z up
struct Body {};      ///< of the robot: x forward, y left, z up
}  // namespace frame

/// p_to = rotation * p_from + translation_m. A wrong product does not compile.
template <typename To, typename From>
struct Transform {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();   ///< rotation matrix [1]: columns are From's axes in To
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();  ///< the origin of `From`, in `To` [m]

  /// The point in `To` [m].
  Eigen::Vector3d operator*(const Eigen::Vector3d& p_from_m) const noexcept {
    return rotation * p_from_m + translation_m;
  }

  template <typename Other>
  Transform<To, Other> operator*(const Transform<From, Other>& T_from_other) const noexcept {
    return {rotation * T_from_other.rotation, rotation * T_from_other.translation_m + translation_m};
  }

  Transform<From, To> inverse() const noexcept {
    return {rotation.transpose(), -(rotation.transpose() * translation_m)};
  }

  /// Unit quaternion with w >= 0.
  Eigen::Quaterniond quaternion() const noexcept {
    Eigen::Quaterniond q(rotation);
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    return q;
  }
};

/// The sheet before the camera.
using CameraFromLandmark = Transform<frame::Camera, frame::Landmark>;

/// Rotation matrix of a rotation vector [rad]: Rodrigues' formula.
inline Eigen::Matrix3d exp_so3(const Eigen::Vector3d& rotation_rad) noexcept {
  const double angle_rad = rotation_rad.norm();
  if (angle_rad < 1e-12) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R(0, 1) = -rotation_rad.z(), R(0, 2) = rotation_rad.y(), R(1, 2) = -rotation_rad.x();
    R(1, 0) = rotation_rad.z(), R(2, 0) = -rotation_rad.y(), R(2, 1) = rotation_rad.x();
    return R;
  }
  return Eigen::AngleAxisd(angle_rad, rotation_rad / angle_rad).toRotationMatrix();
}

/// Rotation vector [rad], angle in [0, pi]. \param R  rotation matrix [1]
inline Eigen::Vector3d log_so3(const Eigen::Matrix3d& R) noexcept {
  const Eigen::AngleAxisd angle_axis(R);
  return angle_axis.angle() * angle_axis.axis();
}

}  // namespace ninedot
