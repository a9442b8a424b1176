#pragma once
/// A landmark's fix with all that makes it less certain than its grey levels say.
#include "pipeline/frame_processor.h"

namespace ninedot {

/// Sets the sighting of the chosen pose, and widens it and that pose by how the dots smear, by how well the rows'
/// motion is known, and by the row time. (What a calibration adds is CalibrationError's.)
/// \param fix  with `id`, `candidates` and `chosen`; a pose that is as the solver left it
/// \param rows  of the sighting \param row_time_sigma_s  1-sigma; 0: the row time is known exactly
/// Memory: none. Threads: pure.
void set_sighting(LandmarkFix& fix, const RowMotion& rows, double row_time_sigma_s, const LandmarkGeometry& landmark,
                  const CameraModel& camera) noexcept;

}  // namespace ninedot
