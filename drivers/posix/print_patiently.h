#pragma once
/// Output for somebody who may have stopped reading: a full pipe, a terminal that stands still, a log that is gone.
#include <chrono>
#include <string_view>

namespace ninedot {

enum class Printed {
  kWhole,
  kCutOff,  ///< its reader was too slow: the rest is lost
  kBroken,  ///< nobody will read it: the other end is closed, the disk is full
};

/// Writes text to a descriptor, waiting for its reader for `patience` at most in all. Never throws, raises no signal
/// where SIGPIPE is ignored. Memory: none. Threads: any, one per descriptor.
Printed print_patiently(int fd, std::string_view text, std::chrono::nanoseconds patience) noexcept;

}  // namespace ninedot
