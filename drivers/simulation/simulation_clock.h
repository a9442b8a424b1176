#pragma once
/// The time of a simulation: the machine's, or one that passes as fast as it is worked through.
#include <thread>

#include "base/mono_time.h"

namespace ninedot {

class SimulationClock {
 public:
  virtual ~SimulationClock() = default;
  /// Threads: any.
  virtual MonoTime now() const noexcept = 0;
  /// Returns at once where that is past. Threads: the camera's.
  virtual void sleep_until(MonoTime until) noexcept = 0;
};

/// CLOCK_MONOTONIC.
class MachineClock final : public SimulationClock {
 public:
  MonoTime now() const noexcept override { return mono_now(); }
  void sleep_until(MonoTime until) noexcept override { std::this_thread::sleep_until(until); }
};

/// Time that passes only when somebody sleeps. Threads: one.
class VirtualClock final : public SimulationClock {
 public:
  MonoTime now() const noexcept override { return now_; }
  void sleep_until(MonoTime until) noexcept override {
    if (until > now_) now_ = until;
  }

 private:
  MonoTime now_ = mono_from_ns(1'000'000'000'000);  // 0 means "never" to some
};

}  // namespace ninedot
