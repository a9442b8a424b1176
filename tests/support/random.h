#pragma once
/// Random numbers that are the same everywhere: the distributions of the standard library differ between libraries.
#include <cmath>
#include <cstdint>
#include <numbers>

namespace ninedot::test {

/// 64 well mixed bits of (seed, counter). S. Vigna's splitmix64: the finaliser of a Weyl sequence, so that any element
/// can be had without those before it.
constexpr std::uint64_t random_bits(std::uint64_t seed, std::uint64_t counter) noexcept {
  std::uint64_t z = seed * 0xD1342543DE82EF95ULL + (counter + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

/// Uniform in (0, 1): never 0, so that its logarithm exists.
constexpr double random_uniform(std::uint64_t seed, std::uint64_t counter) noexcept {
  return (static_cast<double>(random_bits(seed, counter) >> 12U) + 0.5) * 0x1p-52;
}

/// Standard normal (Box-Muller), independent for different (seed, counter).
inline double random_normal(std::uint64_t seed, std::uint64_t counter) noexcept {
  const double radius = std::sqrt(-2 * std::log(random_uniform(seed, 2 * counter)));
  return radius * std::cos(2 * std::numbers::pi * random_uniform(seed, 2 * counter + 1));
}

/// A sequence of them. Threads: one caller.
class Random {
 public:
  explicit Random(std::uint64_t seed) noexcept : seed_(seed) {}
  double uniform(double low, double high) noexcept { return low + (high - low) * random_uniform(seed_, counter_++); }
  double normal() noexcept { return random_normal(~seed_, counter_++); }
  std::uint64_t bits() noexcept { return random_bits(seed_, counter_++); }

 private:
  std::uint64_t seed_;
  std::uint64_t counter_ = 0;
};

}  // namespace ninedot::test
