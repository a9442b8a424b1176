#pragma once
/// One axis of the simulated head: a servo with a limited acceleration and speed, as it truly moves.
///
/// Of a command it hears a multiple of `resolution_rad`, `delay` later. While it is farther from there than
/// `dead_band_rad` it is driven, by the fastest motion that comes to rest at the edge of the dead band; within it is
/// braked. The camera follows with play: it stays until the servo has taken up the `backlash_rad`.
#include <array>
#include <chrono>
#include <cstddef>

#include "base/mono_time.h"

namespace ninedot {

struct ServoDynamics {
  double min_rad = -1, max_rad = 1;  ///< mechanical stops, min < max (contract): commands beyond them end there
  double speed_rad_s = 6;            ///< > 0 (contract)
  double acceleration_rad_s2 = 100;  ///< [rad/s^2], > 0 (contract)
  double dead_band_rad = 0;          ///< to each side of where it was told to stand, >= 0 (contract)
  double backlash_rad = 0;           ///< from one end of the play to the other, >= 0 (contract)
  double resolution_rad = 0;         ///< step of the commands; 0: none
  std::chrono::nanoseconds delay{};  ///< from the command until the servo hears it, >= 0 (contract)
};

/// Memory: inside. Threads: one.
class ServoMotion {
 public:
  /// The motion is integrated in steps of this length or less: a hobby servo turns by 0.1 deg in
  /// one.
  static constexpr std::chrono::nanoseconds kStep = std::chrono::microseconds(250);

  /// Stands at `start_rad` at the time `at`, in the middle of its play, and has always been told to.
  ServoMotion(const ServoDynamics& dynamics, double start_rad, MonoTime at) noexcept;

  /// \param at  not before that of the command before; may lie in the past, if not before `advance`d by more than the
  /// delay
  void command(MonoTime at, double angle_rad) noexcept;

  /// Moves on. A time before the one that it has come to changes nothing.
  void advance(MonoTime to) noexcept;

  /// Where the camera points [rad].
  double angle_rad() const noexcept { return camera_rad_; }
  /// Where the servo's own shaft stands [rad].
  double shaft_rad() const noexcept { return shaft_rad_; }
  /// [rad/s]
  double speed_rad_s() const noexcept { return speed_rad_s_; }

 private:
  struct Pending {
    MonoTime heard_at{};
    double target_rad = 0;
  };

  void integrate(MonoTime to) noexcept;
  void step(double step_s) noexcept;

  const ServoDynamics dynamics_;
  double target_rad_, shaft_rad_, camera_rad_, speed_rad_s_ = 0;
  MonoTime at_;
  // Commands on their way. A frame gives one at most: room for the longest delay, 1 s, at 1000 frames a second.
  std::array<Pending, 1024> pending_{};
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace ninedot
