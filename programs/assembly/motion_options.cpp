#include "programs/assembly/motion_options.h"

#include "base/units.h"

namespace ninedot {
namespace {

Eigen::Vector3d scaled(const std::array<double, 3>& values, double unit) {
  return unit * Eigen::Vector3d(values[0], values[1], values[2]);
}

}  // namespace

PoseFilterOptions pose_filter_options(const Config& config) {
  PoseFilterOptions options;
  options.landmark = {.ring_radius_m = config.landmark.ring_radius_mm * kMetresPerMm,
                      .dot_radius_m = config.landmark.dot_diameter_mm / 2 * kMetresPerMm,
                      .centre_radius_m = config.landmark.centre_diameter_mm / 2 * kMetresPerMm};
  options.acceleration_sigma_m_s2 = config.track.acceleration_sigma_m_s2;
  options.angular_acceleration_sigma_rad_s2 = config.track.angular_acceleration_sigma_deg_s2 * kRadPerDeg;
  options.common_share = config.track.common_share;
  return options;
}

BodyGeometry body_geometry(const BodyConfig& config) {
  return {.pan_axis_m = scaled(config.pan_axis_mm, kMetresPerMm),
          .mount_rpy_rad = scaled(config.mount_rpy_deg, kRadPerDeg),
          .tilt_axis_m = scaled(config.tilt_axis_mm, kMetresPerMm),
          .camera_m = scaled(config.camera_mm, kMetresPerMm),
          .camera_rpy_rad = scaled(config.camera_rpy_deg, kRadPerDeg),
          .pan_sigma_rad = config.pan_sigma_deg * kRadPerDeg,
          .tilt_sigma_rad = config.tilt_sigma_deg * kRadPerDeg,
          .mount_sigma_m = config.mount_sigma_mm * kMetresPerMm,
          .mount_sigma_rad = config.mount_sigma_deg * kRadPerDeg};
}

}  // namespace ninedot
