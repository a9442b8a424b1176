#pragma once
/// The newest value, from one writer to any number of readers; the writer never waits (a sequence lock).
///
/// H. Boehm, "Can seqlocks get along with programming language memory models?", MSPC 2012, section 4: the payload is
/// copied through relaxed atomics, so that a copy torn by the writer is detected and never undefined.
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace ninedot {

/// Memory: the value sits inside, no heap. Threads: `publish` from one thread, `read` from any.
template <typename T>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<T>);
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;

 public:
  explicit LatestValue(const T& initial = T{}) noexcept { store(initial); }
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Replaces the value. Wait-free.
  void publish(const T& value) noexcept {
    const std::uint64_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    store(value);
    version_.store(version + 2, std::memory_order_release);
  }

  /// A copy of one published value, never a mixture of two. Retries while the writer is at work: made for writers that
  /// publish at a frame rate, not in a tight loop.
  T read() const noexcept {
    std::array<std::uint64_t, kWords> copy;
    for (;;) {
      const std::uint64_t before = version_.load(std::memory_order_acquire);
      for (std::size_t i = 0; i < kWords; ++i) copy[i] = words_[i].load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      if ((before & 1U) == 0 && version_.load(std::memory_order_relaxed) == before) break;
    }
    T value;
    std::memcpy(static_cast<void*>(&value), copy.data(), sizeof(T));
    return value;
  }

  /// How often `publish` was called; a reader compares two of them to see that something is new.
  std::uint64_t version() const noexcept { return version_.load(std::memory_order_acquire) / 2; }

 private:
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> copy{};
    std::memcpy(copy.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(copy[i], std::memory_order_relaxed);
  }

  std::atomic<std::uint64_t> version_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace ninedot
