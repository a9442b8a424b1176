#include "drivers/posix/backoff.h"

#include <span>

#include "drivers/posix/poll_until.h"

namespace ninedot {

bool is_rung_within(const WakeUp& wake, std::chrono::nanoseconds pause) noexcept {
  const MonoTime until = mono_now() + pause;
  for (;;) {
    pollfd rung{wake.get(), POLLIN, 0};
    // -1: interrupted, and the time is not over.
    if (const int ready = poll_until(std::span(&rung, 1), until); ready >= 0) return ready > 0;
  }
}

}  // namespace ninedot
