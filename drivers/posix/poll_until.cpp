#include "drivers/posix/poll_until.h"

#include <algorithm>
#include <ctime>

namespace ninedot {

int poll_until(std::span<pollfd> polled, MonoTime wake_at) noexcept {
  timespec wait{};
  if (wake_at != MonoTime::max()) {
    const auto ns = std::max(wake_at - mono_now(), std::chrono::nanoseconds(0)).count();
    wait.tv_sec = static_cast<std::time_t>(ns / 1'000'000'000);
    wait.tv_nsec = static_cast<long>(ns % 1'000'000'000);
  }
  const int ready = ::ppoll(polled.data(), polled.size(), wake_at == MonoTime::max() ? nullptr : &wait, nullptr);
  // After a failure the kernel has written nothing, and what an earlier round left there would be believed.
  if (ready < 0)
    for (pollfd& one : polled) one.revents = 0;
  return ready;
}

}  // namespace ninedot
