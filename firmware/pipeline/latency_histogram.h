#pragma once
/// Distribution of a duration in fixed memory: median, p99, p99.9 and the maximum of any number of values.
///
/// Log-linear buckets (G. Tene, HdrHistogram): exact below 64 us, from there 32 buckets to every doubling, so that a
/// quantile is at most kMaxRelativeError above the true one and never below it by more than a microsecond.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace ninedot {

/// Memory: inside the object, about 7 kB. Threads: one at a time.
class LatencyHistogram {
 public:
  static constexpr double kMaxRelativeError = 1.0 / 32;  ///< share of the true value: one bucket of a doubling's 32
  /// Longer values count as this long; `max` stays exact.
  static constexpr std::chrono::microseconds kLongest{(std::int64_t{1} << 32) - 1};

  /// Negative values count as 0.
  void add(std::chrono::nanoseconds value) noexcept;

  /// Upper edge of the bucket in which the quantile lies, never above `max`; 0 while empty.
  /// \param fraction  0..1, e.g. 0.99
  std::chrono::nanoseconds quantile(double fraction) const noexcept;

  std::chrono::nanoseconds max() const noexcept { return max_; }
  std::uint64_t count() const noexcept { return count_; }

 private:
  static constexpr unsigned kSubBucketBits = 5;                                 // 32 to every doubling
  static constexpr std::size_t kBucketCount = (32 - kSubBucketBits) * 32 + 32;  // values of up to 32 bits of us

  static std::size_t bucket_of(std::uint64_t value_us) noexcept;
  static std::uint64_t upper_edge_us(std::size_t bucket) noexcept;

  std::array<std::uint64_t, kBucketCount> counts_{};
  std::uint64_t count_ = 0;
  std::chrono::nanoseconds max_{};
};

}  // namespace ninedot
