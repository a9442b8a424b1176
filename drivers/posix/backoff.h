#pragma once
/// Pauses between attempts to open a device that is gone: short at first, so that a plug put back at once costs little,
/// then longer and longer, so that one that stays away costs nothing.
#include <algorithm>
#include <chrono>

#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// Memory: inside. Threads: one.
class Backoff {
 public:
  /// What all devices of the service use. The first: USB adapters and cameras are back some 0.1 s after a plug that
  /// jumped. The longest: nobody who has just put a plug back waits longer than this for it to be noticed.
  static constexpr std::chrono::nanoseconds kFirst = std::chrono::milliseconds(100);
  static constexpr std::chrono::nanoseconds kLongest = std::chrono::seconds(5);

  explicit constexpr Backoff(std::chrono::nanoseconds first = kFirst,
                             std::chrono::nanoseconds longest = kLongest) noexcept
      : first_(first), longest_(longest), pause_(first) {}

  /// The pause before the next attempt: `first`, then twice the one before, at most `longest`.
  constexpr std::chrono::nanoseconds next() noexcept {
    const std::chrono::nanoseconds pause = pause_;
    pause_ = std::min(2 * pause_, longest_);
    return pause;
  }
  /// The device works again: the next pause is `first`.
  constexpr void reset() noexcept { pause_ = first_; }

 private:
  std::chrono::nanoseconds first_, longest_, pause_;
};

/// Sleeps for `pause`, or until `wake` is rung. \return  whether it was rung: the thread has to end
bool is_rung_within(const WakeUp& wake, std::chrono::nanoseconds pause) noexcept;

}  // namespace ninedot
