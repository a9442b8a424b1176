#pragma once
/// What OpenCV's vectors lack in one of the versions that this builds with: operators are gone from its NEON vectors
/// since 4.9, and 4.6 has not all of the functions that took their place.
#include <opencv2/core/hal/intrin.hpp>

namespace ninedot {

/// Lanes of ones where a < b, else of zeros. Memory: none. Threads: pure.
template <typename Vector>
Vector less(const Vector& a, const Vector& b) noexcept {
  if constexpr (requires { a < b; })
    return a < b;
  else
    return v_lt(a, b);
}

/// The bits that a and b have both. Memory: none. Threads: pure.
template <typename Vector>
Vector common_bits(const Vector& a, const Vector& b) noexcept {
  if constexpr (requires { a& b; })
    return a & b;
  else
    return v_and(a, b);
}

}  // namespace ninedot
