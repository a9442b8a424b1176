#include "drivers/posix/signals.h"

#include <fcntl.h>
#include <pthread.h>

#include <csignal>
#include <ctime>

#include "drivers/posix/file_descriptor.h"

namespace ninedot {
namespace {

sigset_t termination_set() noexcept {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGHUP);
  return set;
}

bool has_terminal() noexcept {
  return static_cast<bool>(FileDescriptor(::open("/dev/tty", O_RDWR | O_NOCTTY | O_CLOEXEC)));
}

}  // namespace

TerminationSignals::TerminationSignals() noexcept : had_terminal_(has_terminal()) {
  const sigset_t set = termination_set();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

int TerminationSignals::wait(std::chrono::nanoseconds timeout) const noexcept {
  const sigset_t set = termination_set();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(timeout);
  timespec wait_for{};
  wait_for.tv_sec = static_cast<time_t>(seconds.count());
  wait_for.tv_nsec = static_cast<long>((timeout - seconds).count());
  const int signal = sigtimedwait(&set, nullptr, &wait_for);
  return signal > 0 ? signal : 0;
}

bool TerminationSignals::has_lost_terminal() const noexcept { return had_terminal_ && !has_terminal(); }

}  // namespace ninedot
