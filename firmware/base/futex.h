#pragma once
/// Sleeping until another thread changes a word: futex(2). std::atomic::wait has no deadline.
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstdint>
#include <ctime>

#include "base/mono_time.h"

namespace ninedot {

static_assert(sizeof(std::atomic<std::uint32_t>) == 4 && std::atomic<std::uint32_t>::is_always_lock_free);

/// Sleeps while `word` is `expected`, at most until `deadline`; may also come back without a reason. Threads: any.
inline void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, MonoTime deadline) noexcept {
  const std::int64_t ns = to_ns(deadline);
  const timespec until{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  // WAIT_BITSET takes an absolute time of CLOCK_MONOTONIC; WAIT a relative one.
  syscall(SYS_futex, &word, FUTEX_WAIT_BITSET | FUTEX_PRIVATE_FLAG, expected, &until, nullptr, FUTEX_BITSET_MATCH_ANY);
}

/// Wakes all who sleep on `word`. Threads: any; does not wait.
inline void futex_wake_all(std::atomic<std::uint32_t>& word) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAKE | FUTEX_PRIVATE_FLAG, INT_MAX, nullptr, nullptr, 0);
}

}  // namespace ninedot
