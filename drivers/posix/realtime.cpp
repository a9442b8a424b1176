#include "drivers/posix/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>

namespace ninedot {
namespace {

// The frame path needs less than 100 KiB of stack; sanitizers multiply that by about three.
constexpr std::size_t kTouchedStack_bytes = std::size_t{384} * 1024;
#if defined(__SANITIZE_THREAD__)
// glibc carves a thread's static TLS out of its stack, and this sanitizer's is about 0.8 MiB.
constexpr std::size_t kThreadStack_bytes = std::size_t{2048} * 1024;
#else
constexpr std::size_t kThreadStack_bytes = std::size_t{1024} * 1024;
#endif

// volatile: the compiler must not drop the writes; noinline: the array must be gone again afterwards.
[[gnu::noinline]] void touch_stack() noexcept {
  volatile char pages[kTouchedStack_bytes];
  for (std::size_t i = 0; i < kTouchedStack_bytes; i += 1024) pages[i] = 0;
  static_cast<void>(pages[0]);
}

}  // namespace

Result<void> RealtimeThread::enter() noexcept {
  touch_stack();
  pthread_setname_np(pthread_self(), name_);
  if (priority_ == 0) return fail(Errc::kIo, "real-time priority is not asked for", ECANCELED);
  sched_param wanted{};
  wanted.sched_priority = priority_;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  if (error != 0) return fail(Errc::kIo, "real-time priority is refused", error);
  return {};
}

Result<void> lock_memory() noexcept {
  rlimit limit{};
  const bool unlimited = geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
  if (mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) != 0)
    return fail(Errc::kIo, "memory cannot be locked", errno);
  return {};
}

Result<void> use_small_thread_stacks() noexcept {
  constexpr const char* kRefused = "the size of new threads' stacks cannot be set";
  pthread_attr_t attributes;
  if (const int error = pthread_attr_init(&attributes); error != 0) return fail(Errc::kIo, kRefused, error);
  pthread_attr_setstacksize(&attributes, kThreadStack_bytes);
  const int error = pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
  if (error != 0) return fail(Errc::kIo, kRefused, error);
  return {};
}

}  // namespace ninedot
