#include "drivers/posix/backoff.h"

#include <cerrno>
#include <span>
#include <thread>

#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

/// How late a bell may be heard while poll() fails: a tenth of a second is not noticed at the end of a program.
constexpr std::chrono::nanoseconds kNap = std::chrono::milliseconds(100);

}  // namespace

bool is_rung_within(const WakeUp& wake, std::chrono::nanoseconds pause) noexcept {
  const MonoTime until = mono_now() + pause;
  do {
    pollfd rung{wake.get(), POLLIN, 0};
    const int ready = poll_until(std::span(&rung, 1), until);
    if (ready > 0) return true;
    // A system without memory for poll() is no reason to spin: the pause is kept in naps.
    if (ready < 0 && errno != EINTR) std::this_thread::sleep_for(std::min(pause, kNap));
  } while (mono_now() < until);
  return false;
}

}  // namespace ninedot
