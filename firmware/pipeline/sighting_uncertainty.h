#pragma once
/// What makes a sighting less certain than its grey levels say.
///
/// A rolling shutter, where nobody knows how fast the camera turns: a row that is exposed dt after the middle one sees
/// everything shifted by rate times dt. And dots that lie where no sheet would have them.
#include <cmath>

#include "geometry/camera_model.h"
#include "geometry/sheet_motion.h"
#include "pose/estimate.h"
#include "pose/outline_state.h"
#include "world/sighting.h"

namespace ninedot {

/// How well it is known by what a row sees everything shifted against the row above.
struct RowUncertainty {
  // 1-sigma, each axis of the camera; 0: nothing to be uncertain of.
  double of_motion_rad = 0;    ///< per row, because the sheet's motion is not known exactly
  double of_row_time_rad = 0;  ///< per row, because the row time is not
  double of_both_rad = 0;      ///< per row, because neither is: of a first picture, if the camera moves in it
  double middle_row_px = 0;

  double per_row_rad(bool may_move) const noexcept {
    return std::hypot(of_motion_rad, of_row_time_rad, may_move ? of_both_rad : 0);
  }
};

/// A sheet while the rows of a picture are exposed.
struct RowMotion {
  SheetMotion sheet;
  RowUncertainty uncertainty;  ///< of it
};

/// The turn between the middle row and the landmark's is the sighting's own; by what its rows differ among themselves
/// makes each ray less certain. Nine dots do not average it away.
/// Memory: none. Threads: pure.
/// \param may_move  in a picture of which neither the motion nor the row time is known; false: the camera stands then.
/// One landmark alone would never be of use in a first picture otherwise; two contradict each other if it moves.
void widen(LandmarkSighting& sighting, const RowUncertainty& rows, const CameraModel& camera, bool may_move) noexcept;

/// The same of a pose's covariance, for its motion's sake: a turn of the camera about its own centre, and what it does
/// to the landmark's orientation from row to row. What an uncertain row time adds is row_time_share
/// (picture_row_time.h); of a landmark that nothing is known of, neither its motion nor the row time, a pose says what
/// it is if the camera stands.
void widen(PoseEstimate& pose, const RowUncertainty& rows, const CameraModel& camera) noexcept;

/// Where the dots' places scatter about their own pose by more than they claim, they are that much less certain: a
/// colour camera's pattern moves dots of two pixels, and a warped sheet all of them. Never less uncertain than claimed.
/// Memory: none. Threads: pure.
void widen_by_scatter(LandmarkSighting& sighting, const LandmarkGeometry& landmark) noexcept;

/// Where dots draw lines, a camera that gains speed meanwhile, or a shutter that opens slowly, makes them uneven, and
/// moves them all alike, which their places about each other do not show. And long lines run into each other and into
/// the wall, which moves them about each other as well. Memory: none. Threads: pure.
/// \param outlines  its own
void widen_by_smear(LandmarkSighting& sighting, const OutlineState& outlines, const CameraModel& camera) noexcept;
/// The same of a pose's covariance.
void widen_by_smear(PoseEstimate& pose, const OutlineState& outlines, const CameraModel& camera) noexcept;

}  // namespace ninedot
