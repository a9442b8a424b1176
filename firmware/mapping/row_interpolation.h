#pragma once
/// How landmarks moved while a rolling shutter exposed their rows, from the pictures before and after.
///
/// Whoever follows a landmark knows no later picture, and calls a motion what it was a picture ago: rows 8 ms from the
/// middle one are off by half a pixel where a camera swings. In a recording the next picture is there. A landmark's ray
/// at the instant t of its picture is that of the polynomial through its rays at the instants at which its rows were
/// exposed, in this picture and in its neighbours; what the next power would add is the error (C. de Boor, "A Practical
/// Guide to Splines", 1978, chapter I: the remainder of Newton's form).
#include <cstddef>
#include <span>

#include "base/mono_time.h"
#include "geometry/camera_model.h"
#include "geometry/sheet_motion.h"
#include "world/sighting.h"

namespace ninedot {

struct RowedSighting {
  LandmarkSighting* seen = nullptr;  ///< not null (contract); its rays are those of `time`
  MonoTime time;                     ///< when the middle row was exposed
  SheetMotion motion;                ///< that took them there from the instants of their own rows
  double per_row_rad = 0;            ///< how uncertain `motion` makes that, 1-sigma for each row
};

/// Takes the rays to `time` anew by a polynomial of the second degree, or by a straight line, where that is more
/// certain than the motion that they were taken there by, and says how certain it is. Elsewhere, and where all rows are
/// exposed at once, nothing changes. \param sightings  of one recording, in the order of their times Memory: allocates.
/// Threads: one.
void interpolate_rows(std::span<RowedSighting> sightings, const CameraModel& camera);

}  // namespace ninedot
