#pragma once
/// The pan/tilt head. Implemented in drivers/servo.
#include <chrono>
#include <cstdint>

#include "base/head_angles.h"

namespace ninedot {

struct HeadState {
  HeadAngles angles;     ///< where the head stands: as reported by it, else as it was last told
  bool limited = false;  ///< the last command was beyond a pulse limit and was cut there
  bool failed = false;   ///< the newest command could not be carried out, or the head does not answer
  /// How far the widths of software-made pulses are off; 0 where hardware makes them.
  std::chrono::nanoseconds pulse_error_p99{}, pulse_error_max{};
  std::uint32_t losses = 0;  ///< how often the head fell silent or its line vanished
};

/// The constructor brings the head to its neutral position. Memory: none after construction. Threads: one caller.
class PanTilt {
 public:
  virtual ~PanTilt() = default;
  /// Goes there; does not wait for a slow device. Beyond the limits of its hardware it saturates.
  virtual void move_to(const HeadAngles& angles) noexcept = 0;
  /// Ends a motion that is under way.
  virtual void stop() noexcept = 0;
  virtual HeadState state() const noexcept = 0;
};

}  // namespace ninedot
