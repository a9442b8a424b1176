#include "drivers/modbus/server_thread.h"

#include <pthread.h>
#include <sched.h>

#include <csignal>
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

}  // namespace ninedot
