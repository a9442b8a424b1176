// Directions are turned into the head's base frame (x forward, y left, z up), where the goal does not depend on where
// the head stands. The command approaches the goal by a part of the deviation, at most as fast as the axis may turn.
#include "aim/aimer.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

// A longer pause between two steps (a lost camera) must not become a jump afterwards. Three frames at 30 Hz: shorter,
// and a frame or two that went missing would slow the head down.
constexpr std::chrono::duration<double> kLongestStep{0.1};

Eigen::Vector3d forward_left_up(const Eigen::Vector3d& v_camera) noexcept {
  return {v_camera.z(), -v_camera.x(), -v_camera.y()};
}

Eigen::Vector3d in_base(const Eigen::Vector3d& v, const HeadAngles& head) noexcept {
  const double ct = std::cos(head.tilt_rad), st = std::sin(head.tilt_rad);
  const double cp = std::cos(head.pan_rad), sp = std::sin(head.pan_rad);
  const double forward = ct * v.x() - st * v.z();
  return {cp * forward - sp * v.y(), sp * forward + cp * v.y(), st * v.x() + ct * v.z()};
}

bool is_axis(const AimAxis& axis) noexcept { return axis.min_rad < axis.max_rad && axis.slew_rad_per_s > 0; }

/// \param part  of the deviation to take away
double approach(double command_rad, double goal_rad, double part, double dead_band_rad, const AimAxis& axis,
                double step_s) noexcept {
  const double deviation_rad = goal_rad - command_rad;
  if (std::abs(deviation_rad) <= dead_band_rad) return command_rad;
  const double furthest_rad = axis.slew_rad_per_s * step_s;
  return command_rad + std::clamp(part * deviation_rad, -furthest_rad, furthest_rad);
}

}  // namespace

HeadAngles angles_towards(const Eigen::Vector3d& target_camera, const Eigen::Vector3d& centre_camera,
                          const HeadAngles& head) noexcept {
  const Eigen::Vector3d target = in_base(forward_left_up(target_camera).normalized(), head);
  const Eigen::Vector3d centre = forward_left_up(centre_camera).normalized();
  // Height: centre.x sin(tilt) + centre.z cos(tilt) = target.z; then the remaining turn is about the vertical.
  const double reach = std::hypot(centre.x(), centre.z());
  HeadAngles goal;
  goal.tilt_rad = std::asin(std::clamp(target.z() / reach, -1.0, 1.0)) - std::atan2(centre.z(), centre.x());
  const double forward = centre.x() * std::cos(goal.tilt_rad) - centre.z() * std::sin(goal.tilt_rad);
  const double turn_rad = std::atan2(target.y(), target.x()) - std::atan2(centre.y(), forward);
  goal.pan_rad = std::atan2(std::sin(turn_rad), std::cos(turn_rad));
  return goal;
}

Aimer::Aimer(const CameraModel& camera, const AimOptions& options, const HeadAngles& head) noexcept
    : options_(options), centre_camera_(0, 0, 1), command_(options.neutral), track_(head) {
  EXPECTS(is_axis(options.pan) && is_axis(options.tilt));
  EXPECTS(options.gain > 0 && options.gain <= 1 && options.dead_band_rad >= 0);
  if (const auto middle = camera.normalised_from_pixel({(camera.width_px - 1) / 2.0, (camera.height_px - 1) / 2.0}))
    centre_camera_ = middle->homogeneous();
}

AimStep Aimer::step(MonoTime now, const HeadAngles& head, const AimSight& sight, const AimOrder& order,
                    bool inhibited) noexcept {
  track_.add(now, head);
  const bool is_first = stepped_at_ == MonoTime{};
  const double step_s =
      is_first ? 0 : std::clamp(std::chrono::duration<double>(now - stepped_at_), {}, kLongestStep).count();
  stepped_at_ = now;
  if (inhibited) {
    command_ = head;
    return {command_, false, false};
  }
  if (order.follow && !sight.valid) return {command_, false, false};

  const HeadAngles wanted = order.follow
                                ? angles_towards(sight.landmark_camera_m, centre_camera_, track_.at(sight.exposed_at))
                                : order.set_point;
  const HeadAngles goal{std::clamp(wanted.pan_rad, options_.pan.min_rad, options_.pan.max_rad),
                        std::clamp(wanted.tilt_rad, options_.tilt.min_rad, options_.tilt.max_rad)};
  // A set-point is meant exactly; what is seen is noisy and late.
  const double part = order.follow ? options_.gain : 1;
  const double dead_band_rad = order.follow ? options_.dead_band_rad : 0;
  command_.pan_rad = approach(command_.pan_rad, goal.pan_rad, part, dead_band_rad, options_.pan, step_s);
  command_.tilt_rad = approach(command_.tilt_rad, goal.tilt_rad, part, dead_band_rad, options_.tilt, step_s);
  return {command_, goal.pan_rad != wanted.pan_rad || goal.tilt_rad != wanted.tilt_rad,
          command_.pan_rad == goal.pan_rad && command_.tilt_rad == goal.tilt_rad};
}

}  // namespace ninedot
