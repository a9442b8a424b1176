#include "aim/axis_ramp.h"

#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

// Speeds are held for so long: at 20 rad/s^2 an axis goes 0.03 deg meanwhile, below the resolution of any head.
constexpr double kLongestPiece_s = 0.005;

/// The highest speed that, held for a step, leaves enough of the way to stop: v^2 / 2a = way - v step.
double braking_speed(double way_rad, double acceleration, double step_s) noexcept {
  const double lost = acceleration * step_s;
  return std::sqrt(lost * lost + 2 * acceleration * way_rad) - lost;
}

}  // namespace

void AxisRamp::advance(const AxisGoal& goal, const AimAxis& axis, double step_s) noexcept {
  const int pieces = static_cast<int>(std::ceil(std::clamp(step_s, 0.0, 1.0) / kLongestPiece_s));
  for (int i = 1; i <= pieces; ++i) {
    const double left_s = step_s * (pieces - i) / pieces;
    AxisGoal now{goal.angle_rad - goal.rate_rad_per_s * left_s, goal.rate_rad_per_s};
    const double within = std::clamp(now.angle_rad, axis.min_rad, axis.max_rad);
    if (within != now.angle_rad) now = {within, 0};
    advance_briefly(now, axis, step_s / pieces);
  }
}

void AxisRamp::advance_briefly(const AxisGoal& goal, const AimAxis& axis, double step_s) noexcept {
  const double a = axis.acceleration_rad_per_s2, most = a * step_s;
  const double way = goal.angle_rad - angle_rad_ - goal.rate_rad_per_s * step_s;  // beside what the goal goes itself
  const double faster = braking_speed(std::abs(way), a, step_s);
  double wanted = goal.rate_rad_per_s + std::copysign(faster, way);
  wanted = std::clamp(wanted, -axis.slew_rad_per_s, axis.slew_rad_per_s);
  // The ends of the range are goals as well.
  wanted = std::clamp(wanted, -braking_speed(std::max(0.0, angle_rad_ - axis.min_rad), a, step_s),
                      braking_speed(std::max(0.0, axis.max_rad - angle_rad_), a, step_s));
  rate_rad_per_s_ = std::clamp(wanted, rate_rad_per_s_ - most, rate_rad_per_s_ + most);
  angle_rad_ += rate_rad_per_s_ * step_s;
  // Rounding must not keep it from standing there.
  constexpr double kThere_rad = 1e-9;
  if (goal.rate_rad_per_s == 0 && std::abs(goal.angle_rad - angle_rad_) < kThere_rad &&
      std::abs(rate_rad_per_s_) <= most) {
    angle_rad_ = goal.angle_rad;
    rate_rad_per_s_ = 0;
  }
}

double ramp_time_s(double way_rad, const AimAxis& axis) noexcept {
  const double way = std::abs(way_rad), v = axis.slew_rad_per_s, a = axis.acceleration_rad_per_s2;
  return way * a < v * v ? 2 * std::sqrt(way / a) : way / v + v / a;
}

}  // namespace ninedot
