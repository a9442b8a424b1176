#pragma once
/// The worst case of a lock on a board with one core: an ordinary thread is preempted in the middle of its critical
/// section by a thread of middle priority, and the frame loop, above both, wants the lock.
#include <sched.h>

#include <chrono>
#include <functional>
#include <optional>

#include "base/mono_time.h"

namespace ninedot::test {

/// Pins the calling thread, and those that it starts from now on, to one CPU for as long as it lives.
class OneCore {
 public:
  OneCore();
  ~OneCore();
  OneCore(const OneCore&) = delete;
  OneCore& operator=(const OneCore&) = delete;

  static constexpr std::chrono::milliseconds kBurst{10};  ///< how long the thread of middle priority takes the CPU
  struct Times {
    std::chrono::nanoseconds longest_step{};
    int steps = 0;
  };
  /// Calls `step` `rounds` times on a SCHED_FIFO thread, a millisecond apart. After every 14th a thread of lower
  /// SCHED_FIFO priority sleeps for 0 to 60 us, in which ordinary threads run, and then takes the CPU for kBurst.
  /// `ordinary` is called meanwhile, again and again, on the calling thread. \return nothing: SCHED_FIFO is not
  /// permitted
  static std::optional<Times> race(int rounds, const std::function<void()>& step,
                                   const std::function<void()>& ordinary);

 private:
  cpu_set_t before_;
};

}  // namespace ninedot::test
