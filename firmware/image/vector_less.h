#pragma once
/// What OpenCV's vectors lack in one of the versions that this builds with.
#include <opencv2/core/hal/intrin.hpp>

namespace ninedot {

/// Lanes of ones where a < b, else of zeros. OpenCV's operators are gone from its NEON vectors since 4.9, and 4.6 has
/// no v_lt. Memory: none. Threads: pure.
template <typename Vector>
Vector less(const Vector& a, const Vector& b) noexcept {
  if constexpr (requires { a < b; })
    return a < b;
  else
    return v_lt(a, b);
}

}  // namespace ninedot
