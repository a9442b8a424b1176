#pragma once
/// SIGINT, SIGTERM and SIGHUP, taken on the main thread instead of in a handler.
#include <chrono>

namespace ninedot {

/// Blocks SIGINT, SIGTERM and SIGHUP in the calling thread and in all that it starts afterwards, and ignores SIGPIPE (a
/// reader that goes away is no reason to end). Make one before the first thread starts.
class TerminationSignals {
 public:
  /// Threads: main, before it starts any other.
  TerminationSignals() noexcept;

  /// Waits at most `timeout`. Threads: any one at a time whose signals are blocked; main does.
  /// \return  number of the signal, or 0 when none came.
  int wait(std::chrono::nanoseconds timeout) const noexcept;

  /// There was a terminal at the start, and it is gone: that is what a SIGHUP tells then. Threads: any.
  bool has_lost_terminal() const noexcept;

 private:
  bool had_terminal_;
};

}  // namespace ninedot
