#pragma once
/// The newest value, from one writer to any number of readers, who can also wait for a newer one.
///
/// H. Boehm, "Can seqlocks get along with programming language memory models?", MSPC 2012, section 4: the payload is
/// copied through relaxed atomics, so that a copy torn by the writer is detected and never undefined.
///
/// **Who may spin on whom.** A reader tries again while the writer is at work. A real-time thread may therefore read
/// only what a thread of higher priority writes: that one is through before the reader runs at all. An ordinary thread
/// may read what any thread writes: the scheduler takes the processor from it in the end. What goes the other way, from
/// a thread of lower priority to a real-time one, goes through Handoff (handoff.h), where nobody tries again.
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "base/futex.h"
#include "base/mono_time.h"

namespace ninedot {

/// What a test puts in the middle of a write; nothing in the product.
struct NoPause {
  static void in_the_middle() noexcept {}
};

/// Memory: the value sits inside, no heap. Threads: see each method.
template <typename T, typename Pause = NoPause>
class Mailbox {
  static_assert(std::is_trivially_copyable_v<T>);
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;

 public:
  explicit Mailbox(const T& initial = T{}) noexcept { store(initial); }
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// Replaces the value. Wait-free; one system call more if somebody waits. Threads: one, of any priority.
  void publish(const T& value) noexcept {
    const std::uint64_t state = state_.load(std::memory_order_relaxed);
    state_.store(state + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    store(value);
    state_.store(state + 2, std::memory_order_release);
    // Either this thread sees the waiter, or the waiter sees the new word and does not fall asleep: both stand in one
    // order (seq_cst).
    futex_word_.store(static_cast<std::uint32_t>((state + 2) / 2), std::memory_order_seq_cst);
    if (waiters_.load(std::memory_order_seq_cst) != 0) futex_wake_all(futex_word_);
  }

  /// One published value, never a mixture of two, and which publication it is.
  struct Reading {
    T value;
    std::uint64_t version;
  };

  /// Tries again while the writer is at work: made for writers that publish at a frame rate, not in a tight loop.
  /// Threads: any that may spin on the writer (above).
  Reading read_with_version() const noexcept {
    std::array<std::uint64_t, kWords> copy;
    std::uint64_t before = 0;
    for (;;) {
      before = state_.load(std::memory_order_acquire);
      for (std::size_t i = 0; i < kWords; ++i) copy[i] = words_[i].load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      if ((before & 1U) == 0 && state_.load(std::memory_order_relaxed) == before) break;
    }
    Reading reading;
    std::memcpy(static_cast<void*>(&reading.value), copy.data(), sizeof(T));
    reading.version = before / 2;
    return reading;
  }
  /// Threads: as read_with_version.
  T read() const noexcept { return read_with_version().value; }

  /// How often `publish` was called; a reader compares two of them to see that something is new. Threads: any.
  std::uint64_t version() const noexcept { return state_.load(std::memory_order_acquire) / 2; }

  /// Sleeps until there is another version than `seen`, at most until `deadline`.
  /// \param seen  how often `publish` had been called when the caller looked last (`version`)
  /// \return  how often it was called by now; `seen` when nothing came in time
  /// Threads: any; the writer never waits for them.
  std::uint64_t wait_newer(std::uint64_t seen, MonoTime deadline) const noexcept {
    waiters_.fetch_add(1, std::memory_order_seq_cst);
    std::uint64_t newest = version();
    while (newest == seen && mono_now() < deadline) {
      futex_wait(futex_word_, static_cast<std::uint32_t>(seen), deadline);
      newest = version();
    }
    waiters_.fetch_sub(1, std::memory_order_relaxed);
    return newest;
  }

 private:
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> copy{};
    std::memcpy(copy.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < kWords; ++i) {
      if (i == kWords / 2) Pause::in_the_middle();
      words_[i].store(copy[i], std::memory_order_relaxed);
    }
  }

  std::atomic<std::uint64_t> state_{0};       // twice the version; one more while a write is under way
  std::atomic<std::uint32_t> futex_word_{0};  // the version's low half, as the kernel compares it
  mutable std::atomic<std::uint32_t> waiters_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace ninedot
