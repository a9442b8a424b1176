#pragma once
/// What makes a sighting less certain than its grey levels say.
///
/// A rolling shutter, where nobody knows how fast the camera turns: a row that is exposed dt after the middle one sees
/// everything shifted by rate times dt. And dots that lie where no sheet would have them.
#include "geometry/camera_model.h"
#include "geometry/sheet_motion.h"
#include "pose/estimate.h"
#include "world/sighting.h"

namespace ninedot {

/// How well the motion across the rows is known.
struct RowUncertainty {
  double rate_sigma_rad_s = 0;  ///< 1-sigma of the camera's turning rate, each axis
  double row_time_s = 0;        ///< 0: all rows at once, and nothing to be uncertain of
  double middle_row_px = 0;
};

/// The turn between the middle row and the landmark's is the sighting's own; by what its rows differ among themselves
/// makes each ray less certain. Nine dots do not average it away.
/// Memory: none. Threads: pure.
void widen(LandmarkSighting& sighting, const RowUncertainty& rows, const CameraModel& camera) noexcept;

/// The same of a pose's covariance: a turn of the camera about its own centre, and what it does to the landmark's
/// orientation from row to row.
void widen(PoseEstimate& pose, const RowUncertainty& rows, const CameraModel& camera) noexcept;

/// Where the dots' places scatter about their own pose by more than they claim, they are that much less certain: a
/// colour camera's pattern moves dots of two pixels, and a warped sheet all of them. Never less uncertain than claimed.
/// Memory: none. Threads: pure.
void widen_by_scatter(LandmarkSighting& sighting, const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
