#include "colour/disc_picture.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/disc.h"

namespace ninedot {
namespace {

constexpr double kLeast_px = 0.1;  // a semi-axis below this is no disc that anything could be read from

}  // namespace

DiscPicture disc_in_picture(const CameraFromLandmark& T_camera_landmark, const CameraModel& camera,
                            const Eigen::Vector2d& centre_m, double radius_m) noexcept {
  DiscPicture disc;
  const Eigen::Vector3d p = T_camera_landmark * Eigen::Vector3d(centre_m.x(), 0, centre_m.y());
  const Eigen::Vector3d outwards = T_camera_landmark.rotation.col(1);
  if (p.z() <= radius_m || p.dot(outwards) >= 0) return disc;
  Eigen::Matrix2d px_per_ray;
  const Eigen::Vector2d centre_px =
      camera.pixel_from_normalised(project_disc_centre(T_camera_landmark, centre_m, radius_m), &px_per_ray);
  Eigen::Matrix<double, 2, 3> ray_per_point;
  ray_per_point << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z();
  Eigen::Matrix<double, 3, 2> point_per_plane;
  point_per_plane << T_camera_landmark.rotation.col(0), T_camera_landmark.rotation.col(2);
  const Eigen::Matrix2d J = px_per_ray * ray_per_point * point_per_plane * (radius_m / p.z());
  const Eigen::Matrix2d Q = J * J.transpose();
  const double middle = 0.5 * (Q(0, 0) + Q(1, 1));
  const double spread = std::hypot(0.5 * (Q(0, 0) - Q(1, 1)), Q(0, 1));
  const double minor_px = std::sqrt(std::max(middle - spread, 0.0));
  if (!(minor_px >= kLeast_px)) return disc;
  disc.centre_px = centre_px.cast<float>();
  disc.px_per_radius = J.cast<float>();
  disc.radius_per_px = J.inverse().cast<float>();
  disc.semi_major_px = static_cast<float>(std::sqrt(middle + spread));
  disc.semi_minor_px = static_cast<float>(minor_px);
  return disc;
}

}  // namespace ninedot
