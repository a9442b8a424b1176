#include "pose/observation_of_pose.h"

#include "geometry/disc.h"

namespace ninedot {

LandmarkObservation observation_of(const CameraFromLandmark& T_camera_landmark,
                                   const std::array<double, kDotCount>& visible_share, const CameraModel& camera,
                                   const LandmarkGeometry& landmark) noexcept {
  LandmarkObservation seen;
  seen.from_pose = true;
  seen.H_ray_plane << T_camera_landmark.rotation.col(0), T_camera_landmark.rotation.col(2),
      T_camera_landmark.translation_m;
  for (std::size_t i = 0; i < kDotCount; ++i) {
    DotObservation& dot = seen.dots[i];
    dot.visible_fraction = static_cast<float>(visible_share[i]);
    dot.seen = visible_share[i] >= kMinVisible;
    seen.seen_count += dot.seen;
    const Eigen::Vector2d centre_m = landmark.centre_m(i);
    Eigen::Matrix2d px_per_ray;
    dot.centroid_px = camera.pixel_from_normalised(
        project_disc_centre(T_camera_landmark, centre_m, landmark.radius_m(i)), &px_per_ray);
    const Eigen::Vector3d p = T_camera_landmark * Eigen::Vector3d(centre_m.x(), 0, centre_m.y());
    Eigen::Matrix<double, 2, 3> ray_per_point;
    ray_per_point << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z();
    Eigen::Matrix<double, 3, 2> point_per_plane;
    point_per_plane << T_camera_landmark.rotation.col(0), T_camera_landmark.rotation.col(2);
    set_outline(disc_moments(px_per_ray * ray_per_point * point_per_plane / p.z(), landmark.radius_m(i)), dot);
  }
  return seen;
}

}  // namespace ninedot
