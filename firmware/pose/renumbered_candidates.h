#pragma once
/// A solver's answer when another dot of the ring is called P1.
#include "geometry/camera_model.h"
#include "pose/estimate.h"

namespace ninedot {

/// Everything that is said in the sheet's frame or by dots' numbers turns; `rival` is left out: who chooses among
/// readings finds it anew. \param eighths  the dot at this index becomes P1; any integer [1]
/// Memory: none. Threads: pure.
PoseCandidates renumbered(const PoseCandidates& candidates, int eighths, const CameraModel& camera,
                          const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
