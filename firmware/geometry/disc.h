#pragma once
/// The picture of a disc on the landmark's sheet. The centre of its outline is not the picture of its centre.
#include <Eigen/Core>

#include "geometry/transform.h"

namespace ninedot {

/// A disc of the sheet.
struct PlaneDisc {
  Eigen::Vector2d centre_m{0, 0};  ///< (X0, Z0)
  double radius_m = 0;             ///< > 0
};

/// Picture (z = 1) of a point of the sheet. \param plane_m  (X0, Z0)
inline Eigen::Vector2d project_plane_point(const CameraFromLandmark& T_camera_landmark,
                                           const Eigen::Vector2d& plane_m) noexcept {
  return (T_camera_landmark * Eigen::Vector3d(plane_m.x(), 0, plane_m.y())).hnormalized();
}

/// Centre (z = 1) of the ellipse as which a disc of the sheet appears: with H = [X0 Z0 centre], the outline's dual
/// conic is Q = H diag(radius^2, radius^2, -1) H^T and its centre (Q13 / Q33, Q23 / Q33).
inline Eigen::Vector2d project_disc_centre(const CameraFromLandmark& T_camera_landmark, const Eigen::Vector2d& centre_m,
                                           double radius_m) noexcept {
  const Eigen::Vector3d X = radius_m * T_camera_landmark.rotation.col(0);
  const Eigen::Vector3d Z = radius_m * T_camera_landmark.rotation.col(2);
  const Eigen::Vector3d c = T_camera_landmark * Eigen::Vector3d(centre_m.x(), 0, centre_m.y());
  const Eigen::Vector3d column = X * X.z() + Z * Z.z() - c * c.z();  // third column of Q
  return column.head<2>() / column.z();
}

}  // namespace ninedot
