#pragma once
/// The time from row to row of a rolling shutter, from pictures of landmarks while the camera moves.
///
/// A dot in a row that is exposed dt after the middle one is seen where the sheet is then. How the sheet moves is told
/// by the poses of the frames before and after; the time of a row is what makes the dots of all frames agree with their
/// poses. Each frame's pose is unknown too, and eliminated: shear looks like a tilt, all but its perspective, and what
/// a tilt explains says nothing of the rows.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "base/mono_time.h"
#include "geometry/camera_model.h"
#include "geometry/dot_sighting.h"
#include "geometry/sheet_motion.h"
#include "geometry/transform.h"

namespace ninedot {

/// One landmark in one picture.
struct MovingSighting {
  std::uint16_t id = 0;
  MonoTime at{};  ///< of the middle row
  CameraFromLandmark T_camera_landmark;
  DotSightings dots;
  /// That the dots were taken to the middle row with, as the localiser does where a row time is configured, which is
  /// undone here. A default one: they are as they were exposed.
  SheetMotion taken_back_by{};
};

struct RowTimeFit {
  double row_time_s = 0;
  double sigma_s = 0;       ///< of the dots' uncertainty and scatter, or of its scatter between parts of the recording
  std::size_t frames = 0;   ///< sightings that it rests on
  double fastest_px_s = 0;  ///< of a dot through the picture: of the fastest tenth of the sightings
  /// chi^2 of the dots over their freedoms, with the row time. [1]
  double misfit = 1;
};

/// Share of the longest row time: a picture of 480 rows at 35 Hz is known to 0.6 ms from its first row to its last.
inline constexpr double kUsefulRowTime = 0.02;

/// \param sightings  in any order; those of one landmark that follow each other at the frames' period count
/// \param longest_s  between rows that is possible at all: the frames' period over the rows. > 0 (contract)
/// \param useful_share  to how much of that, 1-sigma, it has to be known [1]
/// Throws StartupError(kWorkFailed), one line: too few pictures that follow each other, a motion too slow (with how
/// much faster it must be), a row time that can't be. Memory: allocates.
RowTimeFit fit_row_time(std::span<const MovingSighting> sightings, const CameraModel& camera,
                        const LandmarkGeometry& landmark, double longest_s, double useful_share = kUsefulRowTime);

}  // namespace ninedot
