#pragma once
/// Servo pulses made by software on two GPIO lines: the fallback where the board has no PWM to spare.
///
/// A thread of its own wakes up for every edge (clock_nanosleep on CLOCK_MONOTONIC, absolute), the two pulses half a
/// period apart. Every late wake-up changes a width, and the servo twitches: about 10 us are a degree. The thread
/// measures the width of every pulse; HeadState tells how far off they are. Use hardware PWM where you can.
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "aim/servo_axis.h"
#include "base/mono_time.h"
#include "base/result.h"
#include "drivers/servo/pulse_errors.h"
#include "ports/digital_io.h"

namespace ninedot {

struct GpioPanTiltOptions {
  std::chrono::nanoseconds period = std::chrono::milliseconds(20);  ///< at least twice the longest pulse (contract)
  int realtime_priority = 0;                                        ///< SCHED_FIFO 1..99; 0: ordinary
};

/// Threads: as PanTilt says, and one thread of its own, which shares atomics with the caller and no lock.
class GpioPanTilt final : public PanTilt {
 public:
  /// The outputs are driven by the pulse thread alone. Pulses begin at once, those for `at`. Waits until that thread
  /// knows its priority.
  GpioPanTilt(std::unique_ptr<DigitalOutput> pan, std::unique_ptr<DigitalOutput> tilt,
              const GpioPanTiltOptions& options, const ServoAxes& axes, const HeadAngles& at);
  /// Ends after the pulse that is under way, with both lines low: waits for it, a period at most.
  ~GpioPanTilt() override;

  /// Two relaxed atomic stores; waits for nothing. The pulse thread may take pan from one call and tilt from the next.
  void move_to(const HeadAngles& angles) noexcept override;
  /// Nothing: a servo stands where its pulse says.
  void stop() noexcept override {}
  /// Waits for nothing, but goes through the histogram of widths: some thousand atomic loads.
  HeadState state() const noexcept override;

  /// \error  kIo with the errno with which real-time priority was refused; none where it was not asked for.
  /// Threads: any.
  const Result<void>& realtime() const noexcept { return realtime_; }

 private:
  void run(const std::stop_token& stop) noexcept;
  /// \return  false: the line could not be driven
  bool try_pulse(DigitalOutput& line, MonoTime at, std::chrono::nanoseconds width) noexcept;

  const std::unique_ptr<DigitalOutput> pan_line_, tilt_line_;
  const GpioPanTiltOptions options_;
  const ServoAxes axes_;
  HeadState state_;  // of the caller
  std::atomic<std::int64_t> pan_ns_{0}, tilt_ns_{0};
  std::atomic<bool> failed_{false};
  Result<void> realtime_;  // written before the constructor ends
  PulseErrors errors_;
  std::jthread thread_;  // last: ends before anything it uses
};

}  // namespace ninedot
