#include "calibrate_camera/sheet_map.h"

#include <vector>

namespace ninedot {

bool fit_sheet_map(std::span<const SeenDisc> seen, std::span<const PlaneDisc> discs, Eigen::Matrix3d& H) noexcept {
  std::vector<PlanePoint> matches;
  for (const SeenDisc& disc : seen) matches.push_back({discs[disc.disc].centre_m, disc.centre_px});
  return matches.size() >= 5 && fit_plane_map(matches, H);
}

SheetMap map_of_disc(const Eigen::Matrix3d& H, const PlaneDisc& disc, const Eigen::Vector2d& centre_px) {
  // Centre of the ellipse as which H shows the disc, as project_disc_centre has it.
  const Eigen::Vector3d X = disc.radius_m * H.col(0), Z = disc.radius_m * H.col(1), c = H * disc.centre_m.homogeneous();
  const Eigen::Vector3d column = X * X.z() + Z * Z.z() - c * c.z();
  const Eigen::Vector2d shift_px = centre_px - column.hnormalized();
  return [H, shift_px](const Eigen::Vector2d& plane_m) -> Eigen::Vector2d { return map_point(H, plane_m) + shift_px; };
}

SheetMap map_of_camera(const CameraModel& camera, const CameraFromLandmark& T_camera_landmark) {
  return [camera, T_camera_landmark](const Eigen::Vector2d& plane_m) -> Eigen::Vector2d {
    return camera.pixel_from_normalised(project_plane_point(T_camera_landmark, plane_m));
  };
}

}  // namespace ninedot
