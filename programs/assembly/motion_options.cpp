#include "programs/assembly/motion_options.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace ninedot {
namespace {

Eigen::Vector3d scaled(const std::array<double, 3>& values, double unit) {
  return unit * Eigen::Vector3d(values[0], values[1], values[2]);
}

/// What a head's turn adds to its camera's: an axis gains its fastest turn within the quarter of a second that the
/// track's accelerations last, or what it is allowed of acceleration. [deg/s^2]
double head_acceleration_deg_s2(const PanTiltConfig& head) {
  if (head.driver == "none") return 0;
  constexpr double kLast_s = 0.25;
  const auto of = [](const HeadAxisConfig& axis) {
    return std::min(axis.acceleration_deg_per_s2, axis.slew_deg_per_s / kLast_s);
  };
  return std::max(of(head.pan), of(head.tilt));
}

}  // namespace

PoseFilterOptions pose_filter_options(const Config& config) {
  PoseFilterOptions options;
  options.landmark = {.ring_radius_m = config.landmark.ring_radius_mm * kMetresPerMm,
                      .dot_radius_m = config.landmark.dot_diameter_mm / 2 * kMetresPerMm,
                      .centre_radius_m = config.landmark.centre_diameter_mm / 2 * kMetresPerMm};
  options.acceleration_sigma_m_s2 = config.track.acceleration_sigma_m_s2;
  options.angular_acceleration_sigma_rad_s2 =
      std::hypot(config.track.angular_acceleration_sigma_deg_s2, head_acceleration_deg_s2(config.pan_tilt)) *
      kRadPerDeg;
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
