#pragma once
/// The command of one axis on its way to a goal that may move: as fast as slew and acceleration allow, and not beyond.
#include "aim/aim_options.h"

namespace ninedot {

/// Where an axis should be by the end of a step.
struct AxisGoal {
  double angle_rad = 0;
  double rate_rad_per_s = 0;  ///< at which the goal itself moves
};

/// Goal by time-optimal braking: the speed towards it is never above sqrt(2 a d), d being what is left of the way
/// (Khalil & Dombre, "Modeling, Identification and Control of Robots", 2002, 13.3: trapezoidal velocity profiles).
/// Memory: inside. Threads: one.
class AxisRamp {
 public:
  explicit AxisRamp(double at_rad = 0) noexcept : angle_rad_(at_rad) {}

  /// Where the axis is, at rest: known anew.
  void stand(double at_rad) noexcept { angle_rad_ = at_rad, rate_rad_per_s_ = 0; }

  /// \param goal  at the end of the step; its angle is cut at the axis's limits
  /// \param step_s  0 or more, at most 1
  void advance(const AxisGoal& goal, const AimAxis& axis, double step_s) noexcept;

  double angle_rad() const noexcept { return angle_rad_; }
  double rate_rad_per_s() const noexcept { return rate_rad_per_s_; }

 private:
  void advance_briefly(const AxisGoal& goal, const AimAxis& axis, double step_s) noexcept;

  double angle_rad_, rate_rad_per_s_ = 0;
};

/// How long an axis at rest takes over a way, to rest [s].
double ramp_time_s(double way_rad, const AimAxis& axis) noexcept;

}  // namespace ninedot
