#include "drivers/modbus/server_thread.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <csignal>
#include <ctime>
#include <utility>

namespace ninedot {

std::thread start_server_thread(const char* name, std::function<void()> body) {
  // Blocked here, inherited by the thread: signals belong to the main thread alone.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread([run = std::move(body)] {
    const sched_param none{};
    (void)pthread_setschedparam(pthread_self(), SCHED_OTHER, &none);
    run();
  });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  (void)pthread_setname_np(thread.native_handle(), name);
  return thread;
}

int poll_until(std::span<pollfd> polled, MonoTime wake_at) noexcept {
  timespec wait{};
  if (wake_at != MonoTime::max()) {
    const auto ns = std::max(wake_at - mono_now(), std::chrono::nanoseconds(0)).count();
    wait.tv_sec = static_cast<std::time_t>(ns / 1'000'000'000);
    wait.tv_nsec = static_cast<long>(ns % 1'000'000'000);
  }
  return ::ppoll(polled.data(), polled.size(), wake_at == MonoTime::max() ? nullptr : &wait, nullptr);
}

}  // namespace ninedot
