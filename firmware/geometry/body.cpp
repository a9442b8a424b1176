#include "geometry/body.h"

#include "geometry/euler_angles.h"

namespace ninedot {
namespace {

/// The camera's right is -y of the body, its down -z, its forward x.
Eigen::Matrix3d body_axes_of_optical() noexcept {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

Eigen::Matrix3d rotation_of_rpy(const Eigen::Vector3d& rpy_rad) noexcept {
  return rotation_of(YawPitchRoll{rpy_rad.z(), rpy_rad.y(), rpy_rad.x()});
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) noexcept {
  Eigen::Matrix3d M;
  M << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return M;
}

}  // namespace

CameraOnBody camera_on_body(const BodyGeometry& body, const HeadAngles& head) noexcept {
  const Eigen::Matrix3d R_foot = rotation_of_rpy(body.mount_rpy_rad);
  const Eigen::Matrix3d R_panned = R_foot * exp_so3(head.pan_rad * Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d R_tilted = R_panned * exp_so3(-head.tilt_rad * Eigen::Vector3d::UnitY());
  const Eigen::Vector3d tilt_axis_m = body.pan_axis_m + R_panned * body.tilt_axis_m;
  CameraOnBody camera;
  BodyFromCamera& T = camera.T_body_camera;
  T.rotation = R_tilted * rotation_of_rpy(body.camera_rpy_rad) * body_axes_of_optical();
  T.translation_m = tilt_axis_m + R_tilted * body.camera_m;

  // A turn about an axis of the body moves the camera across its arm, and turns it about the axis as the camera has it.
  const auto add = [&](const Eigen::Vector3d& axis, const Eigen::Vector3d& point_m, double sigma_rad) {
    Eigen::Matrix<double, 6, 1> step;
    step << axis.cross(T.translation_m - point_m), T.rotation.transpose() * axis;
    camera.covariance += sigma_rad * sigma_rad * step * step.transpose();
  };
  add(R_panned.col(2), body.pan_axis_m, body.pan_sigma_rad);
  add(-R_panned.col(1), tilt_axis_m, body.tilt_sigma_rad);
  camera.covariance.diagonal().head<3>().array() += body.mount_sigma_m * body.mount_sigma_m;
  camera.covariance.diagonal().tail<3>().array() += body.mount_sigma_rad * body.mount_sigma_rad;
  return camera;
}

BodyPose body_in_world(const Transform<frame::World, frame::Camera>& T_world_camera,
                       const BodyCovariance& camera_covariance, const CameraOnBody& camera) noexcept {
  const BodyFromCamera& T_body_camera = camera.T_body_camera;
  const Transform<frame::Camera, frame::Body> T_camera_body = T_body_camera.inverse();
  BodyPose pose{T_world_camera * T_camera_body};
  // The body hangs on the camera by an arm: a turn of the camera in the world moves it, and so does the same turn of
  // the camera on the body, the other way.
  const Eigen::Matrix3d arm = T_world_camera.rotation * cross(T_camera_body.translation_m);
  BodyCovariance of_camera, of_mount;
  of_camera << Eigen::Matrix3d::Identity(), -arm, Eigen::Matrix3d::Zero(), T_body_camera.rotation;
  of_mount << -pose.T_world_body.rotation, arm, Eigen::Matrix3d::Zero(), -T_body_camera.rotation;
  pose.covariance =
      of_camera * camera_covariance * of_camera.transpose() + of_mount * camera.covariance * of_mount.transpose();
  return pose;
}

}  // namespace ninedot
