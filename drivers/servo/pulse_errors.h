#pragma once
/// How far pulse widths are off: a histogram of fixed size.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace ninedot {

/// Memory: inside. Threads: per method; atomics without a lock, so nobody ever waits and everything is real-time safe.
class PulseErrors {
 public:
  /// Bins of 1 us up to 1024 us, which is the whole travel of a usual servo; from there on 64 for each doubling, as far
  /// as the register reaches that shows them. The last one holds everything from there on.
  static constexpr std::size_t kFineBins = 1024, kPerDoubling = 64, kDoublings = 6;
  static constexpr std::size_t kBins = kFineBins + kPerDoubling * kDoublings;

  /// Threads: one writer.
  void add(std::chrono::nanoseconds error) noexcept {
    const auto size_ns = static_cast<std::uint64_t>(error.count() < 0 ? -error.count() : error.count());
    bins_[bin_of(size_ns / 1000)].fetch_add(1, std::memory_order_relaxed);
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
      if (below * 100 >= count * 99) return std::min(std::chrono::nanoseconds(1000 * upper_edge_us(i)), max());
    }
    return max();
  }
  /// The largest so far, of either sign; 0 without any. Threads: any.
  std::chrono::nanoseconds max() const noexcept {
    return std::chrono::nanoseconds(max_ns_.load(std::memory_order_relaxed));
  }

 private:
  static std::size_t bin_of(std::uint64_t us) noexcept {
    if (us < kFineBins) return us;
    const auto doubling = static_cast<std::size_t>(std::bit_width(us / kFineBins)) - 1;
    const std::size_t bin =
        kFineBins + kPerDoubling * doubling + ((us * kPerDoubling / kFineBins) >> doubling) - kPerDoubling;
    return std::min(bin, kBins - 1);
  }
  /// Of the last bin as well, which has none.
  static std::uint64_t upper_edge_us(std::size_t bin) noexcept {
    if (bin < kFineBins) return bin + 1;
    const std::size_t doubling = (bin - kFineBins) / kPerDoubling, place = (bin - kFineBins) % kPerDoubling;
    return (kPerDoubling + place + 1) * (kFineBins / kPerDoubling) << doubling;
  }

  std::array<std::atomic<std::uint32_t>, kBins> bins_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace ninedot
