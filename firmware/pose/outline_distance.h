#pragma once
/// How far one pixel lies from a dot's outline, and how that changes with all that a calibration may want to know.
///
/// The same geometry as outline_columns.h has in single precision for eight pixels, here in double precision for one,
/// and with more derivatives: by the camera's intrinsics, and by the time from row to row of a rolling shutter.
#include <Eigen/Core>

#include "base/result.h"
#include "geometry/camera_gradients.h"
#include "geometry/disc.h"
#include "geometry/landmark.h"
#include "geometry/sheet_motion.h"
#include "pose/outline_state.h"

namespace ninedot {

struct OutlineDistance {
  double distance_px = 0;  ///< signed, outside positive, to first order
  /// By the pose: rotation in units of 1 / kLever_m [px m], then translation [px / m]: OutlineState::apply's order.
  Eigen::Matrix<double, 1, kPoseUnknowns> by_pose;
  Eigen::Matrix<double, 1, kIntrinsics> by_intrinsics;  ///< [px] per unit of each
  double by_row_time_px_s = 0;                          ///< by SheetMotion::row_time_s [px / s]
};

/// The derivatives leave out how the outline's steepness changes: exact on the outline, second order beside it.
/// \param T_camera_landmark  at the middle row
/// \error kPoseDegenerate: the pixel's ray does not meet the sheet in front of the camera, or the lens has no inverse
/// Memory: none. Threads: pure.
Result<OutlineDistance> outline_distance(const CameraModel& camera, const PlaneDisc& disc,
                                         const CameraFromLandmark& T_camera_landmark, const Eigen::Vector2d& pixel_px,
                                         const SheetMotion& motion = {}) noexcept;

/// The same of a landmark's dot.
inline Result<OutlineDistance> outline_distance(const CameraModel& camera, const LandmarkGeometry& landmark,
                                                const CameraFromLandmark& T_camera_landmark, std::size_t dot,
                                                const Eigen::Vector2d& pixel_px,
                                                const SheetMotion& motion = {}) noexcept {
  return outline_distance(camera, PlaneDisc{landmark.centre_m(dot), landmark.radius_m(dot)}, T_camera_landmark,
                          pixel_px, motion);
}

}  // namespace ninedot
