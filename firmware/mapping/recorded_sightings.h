#pragma once
/// What one picture of a recording shows of the landmarks.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/mono_time.h"
#include "world/sighting.h"

namespace ninedot {

struct RecordedSightings {
  std::size_t recording = 0;  ///< index in the caller's list [1]
  std::uint64_t frame = 0;    ///< number of the picture in it
  MonoTime time;              ///< of its exposure
  std::vector<LandmarkSighting> list;
  double fastest_px_s = 0;  ///< of them through the picture
};

}  // namespace ninedot
