#pragma once
/// What a camera on a pan/tilt head saw of landmarks, and the moments at which the head stood.
#include <cstddef>
#include <span>
#include <vector>

#include "base/head_angles.h"
#include "base/mono_time.h"
#include "world/sighting.h"

namespace ninedot {

/// One picture.
struct HeadFrame {
  std::size_t recording = 0;  ///< index of it: between two of them robot and landmarks may have been moved
  MonoTime exposed_at{};
  HeadAngles told;  ///< at that instant, as the head tells them
  std::vector<LandmarkSighting> seen;
};

/// The head stood, and one landmark or more stood still before it.
struct HeadStop {
  std::size_t recording = 0;  ///< index of it, as in HeadFrame
  HeadAngles told;            ///< the mean of its pictures
  /// From where each axis came: +1 from below, -1 from above; 0: it has not moved yet. [1]
  int pan_side = 0, tilt_side = 0;
  std::vector<LandmarkSighting> seen;  ///< the mean of its pictures, with what they are worth together
};

struct FoundStops {
  std::vector<HeadStop> stops;
  std::size_t without_landmark = 0;  ///< how many stops beside them showed none
  std::size_t unsteady = 0;          ///< in how many stops beside them the landmark moved
  HeadAngles told_min, told_max;     ///< over all pictures [rad]
};

/// Pictures taken while the told angles change, and for a while afterwards, are left out.
/// \param frames  of each recording by rising time, one recording after the other
/// Memory: allocates. Threads: pure.
FoundStops find_stops(std::span<const HeadFrame> frames);

}  // namespace ninedot
