#include "geometry/dot_sighting.h"

namespace ninedot {

DotSightings renumbered(const DotSightings& dots, int eighths) noexcept {
  constexpr int kDots = kRingDotCount;
  DotSightings out = dots;
  for (int i = 0; i < kDots; ++i)
    out[static_cast<std::size_t>(i)] = dots[static_cast<std::size_t>(((i + eighths) % kDots + kDots) % kDots)];
  return out;
}

}  // namespace ninedot
