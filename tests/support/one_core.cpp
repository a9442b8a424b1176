#include "tests/support/one_core.h"

#include <pthread.h>
#include <semaphore.h>

#include <atomic>
#include <random>
#include <thread>

#include "tests/support/sanitizers.h"

namespace ninedot::test {
namespace {

bool enter_real_time(int priority) {
  const sched_param wanted{priority};
  return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted) == 0;
}

void sleep_for(std::chrono::nanoseconds pause) {
  const timespec wait{0, pause.count()};
  ::clock_nanosleep(CLOCK_MONOTONIC, 0, &wait, nullptr);
}

}  // namespace

OneCore::OneCore() {
  ::sched_getaffinity(0, sizeof before_, &before_);
  int first = 0;
  while (!CPU_ISSET(static_cast<unsigned>(first), &before_)) ++first;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(static_cast<unsigned>(first), &one);
  ::sched_setaffinity(0, sizeof one, &one);
}

OneCore::~OneCore() { ::sched_setaffinity(0, sizeof before_, &before_); }

std::optional<OneCore::Times> OneCore::race(int rounds, const std::function<void()>& step,
                                            const std::function<void()>& ordinary) {
  Times times;
  std::atomic<bool> is_over{false}, is_refused{false};
  sem_t burst;
  ::sem_init(&burst, 0, 0);
  std::thread middle([&] {
    if (!enter_real_time(10)) is_refused = true;
    std::mt19937 random(1);
    for (;;) {
      ::sem_wait(&burst);
      if (is_over) return;
      sleep_for(std::chrono::nanoseconds(random() % 60'000));
      for (const MonoTime until = mono_now() + kBurst; mono_now() < until;) {
      }
    }
  });
  std::thread frame_loop([&] {
    if (!enter_real_time(20)) is_refused = true;
    for (int i = 0; i < rounds && !is_refused; ++i) {
      const MonoTime begun = mono_now();
      step();
      times.longest_step = std::max<std::chrono::nanoseconds>(times.longest_step, mono_now() - begun);
      ++times.steps;
      if (i % 14 == 4) ::sem_post(&burst);
      sleep_for(std::chrono::milliseconds(1));
    }
    is_over = true;
    ::sem_post(&burst);
  });
  while (!is_over) ordinary();
  frame_loop.join();
  middle.join();
  ::sem_destroy(&burst);
#if NINEDOT_THREAD_SANITIZER
  is_refused = true;  // this sanitizer has locks of its own, in every access
#endif
  return is_refused ? std::nullopt : std::optional(times);
}

}  // namespace ninedot::test
