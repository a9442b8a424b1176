#include "pose/observation_of_pose.h"

#include <algorithm>
#include <cmath>

#include "geometry/disc.h"

namespace ninedot {
namespace {

/// The ellipse as which a small circle appears: the circle's image under the map's derivative there.
void set_ellipse(const Eigen::Matrix2d& px_per_m, double radius_m, DotObservation& dot) noexcept {
  const Eigen::Matrix2d Q = px_per_m * px_per_m.transpose();
  const double middle = 0.5 * (Q(0, 0) + Q(1, 1));
  const double spread = std::hypot(0.5 * (Q(0, 0) - Q(1, 1)), Q(0, 1));
  dot.semi_major_px = radius_m * std::sqrt(middle + spread);
  dot.semi_minor_px = radius_m * std::sqrt(std::max(middle - spread, 0.0));
  dot.angle_rad = 0.5 * std::atan2(2 * Q(0, 1), Q(0, 0) - Q(1, 1));
}

}  // namespace

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
    set_ellipse(px_per_ray * ray_per_point * point_per_plane / p.z(), landmark.radius_m(i), dot);
  }
  return seen;
}

}  // namespace ninedot
