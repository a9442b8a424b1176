#include "pose/outline_distance.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

// The formulas of outline_columns.cpp: rho is the distance on the sheet from the dot's middle to where the ray meets
// it, h how rho changes with a move of the sheet, reversed; moving the ray by dm changes rho by z h . dm.

namespace ninedot {

Result<OutlineDistance> outline_distance(const CameraModel& camera, const PlaneDisc& disc,
                                         const CameraFromLandmark& T_camera_landmark, const Eigen::Vector2d& pixel_px,
                                         const SheetMotion& motion) noexcept {
  NINEDOT_TRY(const Eigen::Vector2d point, camera.normalised_from_pixel(pixel_px));
  // The pose while this row was exposed.
  const double rows = pixel_px.y() - motion.middle_row_px;
  const CameraFromLandmark T = motion.after(T_camera_landmark, motion.since_s(pixel_px.y()));

  const Eigen::Vector3d rX = T.rotation.col(0), rZ = T.rotation.col(2), n = T.rotation.col(1), m = point.homogeneous();
  Eigen::Matrix3d G;
  G << rX, rZ, T.translation_m;
  const Eigen::Vector3d q = G.inverse() * m;
  if (!(q.z() > 0)) return fail(Errc::kPoseDegenerate, "a pixel's ray does not meet the sheet in front of the camera");
  const double depth_m = 1 / q.z();
  const Eigen::Vector2d from_middle_m = q.hnormalized() - disc.centre_m;
  const double rho_m = from_middle_m.norm();
  const Eigen::Vector3d g = (from_middle_m.x() * rX + from_middle_m.y() * rZ) / rho_m;
  const Eigen::Vector3d h = g - n * (g.dot(m) / n.dot(m));

  Eigen::Matrix2d px_per_ray;
  camera.pixel_from_normalised(point, &px_per_ray);
  const double m_per_px = (depth_m * px_per_ray.inverse().transpose() * h.head<2>()).norm();
  if (!std::isfinite(rho_m) || !(m_per_px > 0)) return fail(Errc::kPoseDegenerate, "a pixel sees the sheet edge on");

  OutlineDistance out;
  out.distance_px = (rho_m - disc.radius_m) / m_per_px;
  const Eigen::Vector3d p = depth_m * m;
  out.by_pose << -((p - T.translation_m).cross(h)).transpose() / (kLever_m * m_per_px), -h.transpose() / m_per_px;
  out.by_intrinsics = (depth_m / m_per_px) * h.head<2>().transpose() * ray_by_intrinsics(camera, point);
  out.by_row_time_px_s = rows * (out.by_pose.head<3>().dot(kLever_m * motion.rotation_rad_s) +
                                 out.by_pose.tail<3>().dot(motion.translation_m_s));
  return out;
}

}  // namespace ninedot
