#pragma once
/// The pan/tilt head. Implemented in drivers/servo.
#include <chrono>
#include <cstdint>
#include <optional>

#include "base/head_angles.h"
#include "base/servo_health.h"
#include "base/zoom_stand.h"

namespace ninedot {

/// Trivially copyable: it crosses threads inside a report.
struct HeadState {
  HeadAngles angles;      ///< where the head stands: as reported by it, else as it was last told
  bool measured = false;  ///< reported by the head itself; else it gets there some time after it was told
  bool absent = false;    ///< it is not there: `angles` are where it is expected to be
  bool limited = false;   ///< the last command was beyond a pulse limit and was cut there
  bool failed = false;    ///< the newest command could not be carried out, or the head does not answer
  /// How far the widths of software-made pulses are off; 0 where hardware makes them.
  std::chrono::nanoseconds pulse_error_p99{}, pulse_error_max{};
  std::uint32_t losses = 0;       ///< how often the head fell silent or its line vanished
  ServoHealth servos;             ///< what smart servos tell; unknown of others
  std::optional<ZoomStand> zoom;  ///< of the lens on it; none: on its way, not known, or the head has none
};

/// The constructor leaves the head where it is, as far as that is known; who moves it ramps from `state`. Memory: none
/// after construction.
///
/// Threads: main constructs and destroys it, before the frame loop begins and after it has ended; both may wait for the
/// device. In between `move_to`, `stop` and `state` belong to one caller, the frame loop; the first two
/// once the report is out. None of them waits for a lock or for another thread; what else one may wait for, each
/// implementation says.
class PanTilt {
 public:
  virtual ~PanTilt() = default;
  /// Goes there; does not wait for the head to arrive. Beyond the limits of its hardware it saturates.
  virtual void move_to(const HeadAngles& angles) noexcept = 0;
  /// Ends a motion that is under way.
  virtual void stop() noexcept = 0;
  /// What is known now; asks no device.
  virtual HeadState state() const noexcept = 0;
};

}  // namespace ninedot
