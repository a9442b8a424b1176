// The step: of all speeds at the end of it that the acceleration allows, the largest from which the rest of the way
// still suffices to brake. With the way e left, the speed v now and v' at the end of a step of length h, the way after
// it is e - (v + v') h / 2, and must be v'^2 / (2 a): a quadratic equation for v'.
#include "drivers/simulation/servo_motion.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

double seconds(std::chrono::nanoseconds duration) noexcept { return std::chrono::duration<double>(duration).count(); }

}  // namespace

ServoMotion::ServoMotion(const ServoDynamics& dynamics, double start_rad, MonoTime at) noexcept
    : dynamics_(dynamics), target_rad_(start_rad), shaft_rad_(start_rad), camera_rad_(start_rad), at_(at) {
  EXPECTS(dynamics.min_rad < dynamics.max_rad && dynamics.speed_rad_s > 0 && dynamics.acceleration_rad_s2 > 0);
  EXPECTS(dynamics.dead_band_rad >= 0 && dynamics.backlash_rad >= 0 && dynamics.delay.count() >= 0);
}

void ServoMotion::command(MonoTime at, double angle_rad) noexcept {
  const double step_rad = dynamics_.resolution_rad;
  if (step_rad > 0) angle_rad = std::round(angle_rad / step_rad) * step_rad;
  const Pending heard{at + dynamics_.delay, std::clamp(angle_rad, dynamics_.min_rad, dynamics_.max_rad)};
  if (count_ < pending_.size()) ++count_;  // else the newest takes the place of the one before
  pending_[(first_ + count_ - 1) % pending_.size()] = heard;
}

void ServoMotion::advance(MonoTime to) noexcept {
  for (; count_ > 0 && pending_[first_].heard_at <= to; --count_) {
    integrate(pending_[first_].heard_at);
    target_rad_ = pending_[first_].target_rad;
    first_ = (first_ + 1) % pending_.size();
  }
  integrate(to);
}

void ServoMotion::integrate(MonoTime to) noexcept {
  while (at_ < to) {
    const std::chrono::nanoseconds length = std::min(kStep, to - at_);
    step(seconds(length));
    at_ += length;
  }
}

void ServoMotion::step(double step_s) noexcept {
  const double off_rad = target_rad_ - shaft_rad_;
  const double way_rad = std::copysign(std::max(0.0, std::abs(off_rad) - dynamics_.dead_band_rad), off_rad);
  const double a = dynamics_.acceleration_rad_s2;
  const double full_step_s = seconds(kStep);
  // What is left of the way and of the speed would be overshot by one step.
  if (std::abs(way_rad) <= a * full_step_s * full_step_s / 2 && std::abs(speed_rad_s_) <= a * full_step_s) {
    shaft_rad_ += way_rad;
    speed_rad_s_ = 0;
  } else {
    const double side = std::copysign(1.0, way_rad);
    const double after_half_rad = std::abs(way_rad) - side * speed_rad_s_ * step_s / 2;
    double wanted_rad_s = 0;
    if (way_rad != 0 && after_half_rad > 0)
      wanted_rad_s = a * (std::sqrt(step_s * step_s / 4 + 2 * after_half_rad / a) - step_s / 2);
    wanted_rad_s = side * std::min(wanted_rad_s, dynamics_.speed_rad_s);
    const double before_rad_s = speed_rad_s_;
    speed_rad_s_ += std::clamp(wanted_rad_s - speed_rad_s_, -a * step_s, a * step_s);
    shaft_rad_ += (before_rad_s + speed_rad_s_) / 2 * step_s;
    if (shaft_rad_ != std::clamp(shaft_rad_, dynamics_.min_rad, dynamics_.max_rad)) {
      shaft_rad_ = std::clamp(shaft_rad_, dynamics_.min_rad, dynamics_.max_rad);
      speed_rad_s_ = 0;
    }
  }
  const double play_rad = dynamics_.backlash_rad / 2;
  camera_rad_ = std::clamp(camera_rad_, shaft_rad_ - play_rad, shaft_rad_ + play_rad);
}

}  // namespace ninedot
