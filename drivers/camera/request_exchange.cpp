#include "drivers/camera/request_exchange.h"

#include <pthread.h>

#include <bit>
#include <cerrno>
#include <csignal>
#include <utility>

namespace ninedot {

RequestExchange::RequestExchange(std::function<void(std::uint32_t)> queue_again)
    : queue_again_(std::move(queue_again)) {
  // Signals are for the main thread, which waits for them.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  thread_ = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(thread_.native_handle(), "requests");
}

void RequestExchange::complete(std::uint32_t request) noexcept {
  const std::uint32_t older = newest_.put(request, {.flagged = std::exchange(damaged_, 0)});
  completed_.ring();
  if (older != NewestWins::kNone) give_back(older);
}

void RequestExchange::complete_damaged(std::uint32_t request) noexcept {
  ++damaged_;
  give_back(request);
}

void RequestExchange::lose(const char* why) noexcept {
  lost_.store(why, std::memory_order_release);
  completed_.ring();
}

Result<NewestWins::Taken> RequestExchange::take(MonoTime deadline) noexcept {
  for (bool is_in_time = true;; is_in_time = completed_.wait_until(deadline)) {
    if (const char* const why = lost_.load(std::memory_order_acquire)) return fail(Errc::kCameraLost, why, ENODEV);
    if (const auto taken = newest_.take()) return *taken;
    if (!is_in_time) return fail(Errc::kNoFrame, "no frame in time");
  }
}

void RequestExchange::give_back(std::uint32_t request) noexcept {
  returned_.fetch_or(1U << request, std::memory_order_release);
  to_queue_.ring();
}

void RequestExchange::run() noexcept {
  for (;;) {
    to_queue_.wait_until(MonoTime::max());
    if (stop_.load(std::memory_order_acquire)) return;
    for (std::uint32_t left = returned_.exchange(0, std::memory_order_acquire); left != 0; left &= left - 1)
      queue_again_(static_cast<std::uint32_t>(std::countr_zero(left)));
  }
}

void RequestExchange::stop() noexcept {
  if (!thread_.joinable()) return;
  stop_.store(true, std::memory_order_release);
  to_queue_.ring();
  thread_.join();
}

}  // namespace ninedot
