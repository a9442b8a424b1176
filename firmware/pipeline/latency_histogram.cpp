// A value v of n bits falls into the bucket of its leading one and the five bits after it. Values below 64 have a
// bucket each; a value with more bits shares one with 2^(n-6) neighbours.
#include "pipeline/latency_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace ninedot {

std::size_t LatencyHistogram::bucket_of(std::uint64_t value_us) noexcept {
  const unsigned bits = static_cast<unsigned>(std::bit_width(value_us));
  if (bits <= kSubBucketBits + 1) return value_us;
  const unsigned shift = bits - (kSubBucketBits + 1);
  return (static_cast<std::size_t>(shift) << kSubBucketBits) + (value_us >> shift);
}

std::uint64_t LatencyHistogram::upper_edge_us(std::size_t bucket) noexcept {
  constexpr std::size_t kPerDoubling = std::size_t{1} << kSubBucketBits;
  if (bucket < 2 * kPerDoubling) return bucket + 1;
  const std::size_t shift = bucket / kPerDoubling - 1;
  const std::uint64_t leading = bucket % kPerDoubling + kPerDoubling;
  return (leading + 1) << shift;
}

void LatencyHistogram::add(std::chrono::nanoseconds value) noexcept {
  value = std::max(value, std::chrono::nanoseconds::zero());
  const auto capped = std::min(std::chrono::floor<std::chrono::microseconds>(value), kLongest);
  ++counts_[bucket_of(static_cast<std::uint64_t>(capped.count()))];
  ++count_;
  max_ = std::max(max_, value);
}

std::chrono::nanoseconds LatencyHistogram::quantile(double fraction) const noexcept {
  if (count_ == 0) return {};
  const double wanted = std::ceil(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(count_));
  const std::uint64_t rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(wanted));
  std::uint64_t below = 0;
  for (std::size_t bucket = 0; bucket < kBucketCount; ++bucket) {
    below += counts_[bucket];
    if (below < rank) continue;
    const std::chrono::nanoseconds edge = std::chrono::microseconds(upper_edge_us(bucket));
    return std::min(edge, max_);
  }
  return max_;
}

}  // namespace ninedot
