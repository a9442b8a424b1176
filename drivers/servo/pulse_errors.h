#pragma once
/// How far pulse widths are off: a histogram of fixed size.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace ninedot {

/// Memory: inside. Threads: per method; atomics without a lock, so nobody ever waits and everything is real-time safe.
class PulseErrors {
 public:
  /// Bins of 1 us; the last one holds everything from there on. 1 ms is the whole travel of a usual servo.
  static constexpr std::size_t kBins = 1000;

  /// Threads: one writer.
  void add(std::chrono::nanoseconds error) noexcept {
    const auto size_ns = static_cast<std::uint64_t>(error.count() < 0 ? -error.count() : error.count());
    bins_[std::min<std::size_t>(size_ns / 1000, kBins - 1)].fetch_add(1, std::memory_order_relaxed);
    if (size_ns > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(size_ns, std::memory_order_relaxed);
  }
  /// The upper edge of the bin below which 99 % lie; 0 without any. Threads: any; what is added meanwhile may be
  /// counted or not.
  std::chrono::nanoseconds p99() const noexcept {
    std::uint64_t count = 0, below = 0;
    for (const auto& bin : bins_) count += bin.load(std::memory_order_relaxed);
    if (count == 0) return {};
    for (std::size_t i = 0; i < kBins; ++i) {
      below += bins_[i].load(std::memory_order_relaxed);
      if (below * 100 >= count * 99) return std::min(std::chrono::nanoseconds(1000 * (i + 1)), max());
    }
    return max();
  }
  /// The largest so far, of either sign; 0 without any. Threads: any.
  std::chrono::nanoseconds max() const noexcept {
    return std::chrono::nanoseconds(max_ns_.load(std::memory_order_relaxed));
  }

 private:
  std::array<std::atomic<std::uint32_t>, kBins> bins_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace ninedot
