#pragma once
/// Two servos behind a bus, as BusPanTilt drives them: a PWM chip on I2C, or servos with a serial line.
#include <optional>

#include "base/result.h"
#include "base/servo_health.h"

namespace ninedot {

/// For pan and tilt what their axes put out: pulse widths [us] or positions [steps].
struct ServoTargets {
  double pan = 0, tilt = 0;
  friend bool operator==(const ServoTargets&, const ServoTargets&) = default;
};

/// For pan and tilt what was put out already, by a service that crashed; none: nothing.
struct RunningTargets {
  std::optional<double> pan, tilt;  ///< [us] or [steps], as those of ServoTargets
};

struct ServoReading {
  std::optional<ServoTargets> position;  ///< where the servos are; none: they don't tell
  ServoHealth health;
};

/// Set up by whoever opens it, without force or pulses until the first `drive`, but for those of `running`; closed by
/// its destructor, which leaves the servos as they are.
///
/// Every method: \error  kIo: after a bounded number of attempts, the bus or what hangs on it is lost, and has to be
/// opened anew; the text says what happened. Memory: none. Threads: one at a time; each waits for the bus, for a time
/// that the implementation says.
class ServoBus {
 public:
  virtual ~ServoBus() = default;
  /// Goes there, with force or pulses from now on.
  virtual Result<void> drive(const ServoTargets& targets) noexcept = 0;
  /// No force and no pulses, until the next `drive`. Tries both servos even if one fails.
  virtual Result<void> release() noexcept = 0;
  /// Asks where the servos are, and whether they still are as they were set up.
  virtual Result<ServoReading> look() noexcept = 0;
  /// What the bus was found putting out when it was opened, and goes on with until the first `drive`. Asks nobody.
  virtual RunningTargets running() const noexcept { return {}; }
};

}  // namespace ninedot
