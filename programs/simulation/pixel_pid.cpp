#include "programs/simulation/pixel_pid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>

#include "base/units.h"

namespace ninedot {
namespace {

// A longer pause between two sights must not become a jump.
constexpr double kLongestStep_s = 0.1;

/// Adds a rate to a command, within the axis's limits. \return  whether it is at none of them
bool turn(double& command_rad, double rate_rad_s, double step_s, const AimAxis& axis) {
  const double wanted_rad = command_rad + std::clamp(rate_rad_s, -axis.slew_rad_per_s, axis.slew_rad_per_s) * step_s;
  command_rad = std::clamp(wanted_rad, axis.min_rad, axis.max_rad);
  return command_rad == wanted_rad && std::abs(rate_rad_s) <= axis.slew_rad_per_s;
}

}  // namespace

PixelPid::PixelPid(const CameraModel& camera, const AimOptions& options, PanTilt& head, const PidGains& gains) noexcept
    : camera_(camera), options_(options), head_(head), gains_(gains), command_(options.neutral) {
  snapshot_.track = HeadTrack(head.state().angles);
}

void PixelPid::take(const Report& newest, bool is_new, MonoTime now) noexcept {
  snapshot_.track.add(now, head_.state().angles);
  const auto& [w, x, y, z] = newest.camera_in_landmark.quaternion_wxyz;
  const Eigen::Vector3d camera_m(newest.camera_in_landmark.position_m.data());
  const Eigen::Vector3d p9_camera_m = Eigen::Quaterniond(w, x, y, z).conjugate() * -camera_m;
  if (!is_new || !newest.valid || p9_camera_m.z() <= 0) {
    if (is_new) seen_at_ = {};
    return;
  }
  const Eigen::Vector2d middle_px((camera_.width_px - 1) / 2.0, (camera_.height_px - 1) / 2.0);
  const Eigen::Vector2d error_px = camera_.pixel_from_normalised(p9_camera_m.hnormalized()) - middle_px;
  const bool has_before = seen_at_ != MonoTime{};
  const double step_s =
      has_before ? std::min(std::chrono::duration<double>(now - seen_at_).count(), kLongestStep_s) : 0;
  if (step_s > 0) {
    const Eigen::Vector2d integral_px_s = integral_px_s_ + step_s * error_px;
    const Eigen::Vector2d rate_deg_s = gains_.kp_deg_s_px * error_px + gains_.ki_deg_s2_px * integral_px_s +
                                       gains_.kd_deg_px * (error_px - error_px_) / step_s;
    // Right and down in the picture are negative angles. The integral stands still at a limit.
    if (turn(command_.pan_rad, -rate_deg_s.x() * kRadPerDeg, step_s, options_.pan))
      integral_px_s_.x() = integral_px_s.x();
    if (turn(command_.tilt_rad, -rate_deg_s.y() * kRadPerDeg, step_s, options_.tilt))
      integral_px_s_.y() = integral_px_s.y();
    head_.move_to(command_);
  }
  error_px_ = error_px;
  seen_at_ = now;
}

}  // namespace ninedot
