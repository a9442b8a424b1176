#include "drivers/posix/signals.h"

#include <pthread.h>

#include <csignal>
#include <ctime>

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

}  // namespace

TerminationSignals::TerminationSignals() noexcept {
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

}  // namespace ninedot
