#include "drivers/posix/print_patiently.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <span>

#include "drivers/posix/poll_until.h"

namespace ninedot {

Printed print_patiently(int fd, std::string_view text, std::chrono::nanoseconds patience) noexcept {
  const MonoTime until = mono_now() + patience;
  while (!text.empty()) {
    pollfd out{fd, POLLOUT, 0};
    const int ready = poll_until(std::span(&out, 1), until);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) return Printed::kCutOff;
    if (ready < 0 || (out.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) return Printed::kBroken;
    // So much a pipe takes at once when it says that it takes anything (POSIX, PIPE_BUF).
    const ssize_t count = ::write(fd, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
    if (count < 0 && errno != EINTR && errno != EAGAIN) return Printed::kBroken;
    if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
  }
  return Printed::kWhole;
}

}  // namespace ninedot
