#pragma once
/// Random bits that are the same everywhere.
#include <cstdint>

namespace ninedot {

/// 64 well mixed bits of (seed, counter) [1]. S. Vigna's splitmix64.
/// \param counter  [1]
constexpr std::uint64_t mixed_bits(std::uint64_t seed, std::uint64_t counter) noexcept {
  std::uint64_t z = seed + (counter + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

}  // namespace ninedot
