#pragma once
/// How a sheet moves before the camera while the rows of a picture are exposed one after the other.
#include <Eigen/Geometry>

#include "geometry/camera_model.h"
#include "geometry/transform.h"

namespace ninedot {

struct SheetMotion {
  Eigen::Vector3d rotation_rad_s{0, 0, 0};   ///< about the landmark's origin, camera frame
  Eigen::Vector3d translation_m_s{0, 0, 0};  ///< camera frame
  double row_time_s = 0;                     ///< from one row to the next below; 0: all at once
  double middle_row_px = 0;                  ///< the row that the pose is of
  double exposure_s = 0;                     ///< how long each row is exposed; 0: unknown, or it does not matter

  /// When a row is exposed, after the middle one. \param row_px  its number
  double since_s(double row_px) const noexcept { return (row_px - middle_row_px) * row_time_s; }

  /// Where the sheet is a little later. \param T_camera_landmark  at the middle row
  CameraFromLandmark after(const CameraFromLandmark& T_camera_landmark, double time_s) const noexcept {
    return {exp_so3(time_s * rotation_rad_s) * T_camera_landmark.rotation,
            T_camera_landmark.translation_m + time_s * translation_m_s};
  }

  /// How fast a point of the sheet moves through the picture, as a ray. \param p_camera_m  the point
  /// \param t_camera_m  the landmark's origin \return  [1/s]
  Eigen::Vector2d ray_velocity(const Eigen::Vector3d& p_camera_m, const Eigen::Vector3d& t_camera_m) const noexcept {
    const Eigen::Vector3d v_m_s = rotation_rad_s.cross(p_camera_m - t_camera_m) + translation_m_s;
    return (v_m_s.head<2>() - p_camera_m.hnormalized() * v_m_s.z()) / p_camera_m.z();
  }
};

/// The sheet while the rows that show it are exposed: where it is in the picture, to the motion across its own rows.
/// \param T_camera_landmark  at the middle row
/// Memory: none. Threads: pure.
inline CameraFromLandmark as_exposed(const CameraFromLandmark& T_camera_landmark, const SheetMotion& motion,
                                     const CameraModel& camera) noexcept {
  if (motion.row_time_s == 0 || !(T_camera_landmark.translation_m.z() > 0)) return T_camera_landmark;
  CameraFromLandmark T = T_camera_landmark;
  for (int i = 0; i < 2; ++i) {  // the row depends on the place, but by a hundredth of it
    const double row_px = camera.pixel_from_normalised(T.translation_m.hnormalized()).y();
    T = motion.after(T_camera_landmark, motion.since_s(row_px));
    if (!(T.translation_m.z() > 0)) return T_camera_landmark;
  }
  return T;
}

}  // namespace ninedot
