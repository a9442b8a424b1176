#pragma once
/// Whether one axis should stand: a dead band with hysteresis, which widens where the head hunts.
///
/// A servo does not answer changes within its own dead band, and a train of gears has play; what is sent then and what
/// is seen differ, and a controller that goes on correcting swings to and fro for ever. Each swing that is larger than
/// the dead band doubles it here, until the axis rests; a goal elsewhere brings the configured one back.
#include <chrono>
#include <optional>

#include "aim/axis_ramp.h"
#include "base/mono_time.h"
#include "base/units.h"

namespace ninedot {

/// Memory: inside. Threads: one.
class Standing {
 public:
  /// Swings of hunting are smaller, a landmark that moves is larger: twice the dead band of the coarsest servos in use,
  /// 1 deg, and half as much again.
  static constexpr double kSwing_rad = 3 * kRadPerDeg;
  /// Half of it: a servo with a dead band of 1 deg stands within 1 deg of any goal.
  static constexpr double kWidest_rad = 1.5 * kRadPerDeg;

  /// \param dead_band_rad  0 or more
  explicit Standing(double dead_band_rad) noexcept : own_rad_(dead_band_rad), band_rad_(dead_band_rad) {}

  /// What the axis is to go to: `goal`, or the place at which it rests.
  /// \param command  as it is before this step
  AxisGoal step(MonoTime now, const AxisGoal& goal, const AxisRamp& command) noexcept;
  /// The axis does something else: it rests no more.
  void leave() noexcept { rests_ = false; }

  bool rests() const noexcept { return rests_; }
  double band_rad() const noexcept { return band_rad_; }

 private:
  void watch_for_swings(MonoTime now, const AxisRamp& command) noexcept;

  double own_rad_, band_rad_;
  bool rests_ = false;
  double rest_rad_ = 0;
  std::optional<double> turned_rad_;  // where the command turned last
  double furthest_rad_ = 0;           // from there, so far
  MonoTime turned_at_{};
  std::optional<MonoTime> near_since_;  // its goal, without a break
};

}  // namespace ninedot
