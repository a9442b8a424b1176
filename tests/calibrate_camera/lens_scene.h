#pragma once
/// Views of a sheet through a lens that is known exactly: rendered pictures, or the outlines alone.
#include <cstdint>
#include <span>
#include <vector>

#include "calibrate_camera/sheet_view.h"
#include "geometry/camera_model.h"
#include "geometry/dot_grid.h"
#include "geometry/transform.h"
#include "tests/support/renderer.h"

namespace ninedot::test {

/// How the sheet is held before the camera: near, all over the picture, tilted every way.
struct Holding {
  double min_distance_m = 0.33, max_distance_m = 1.0;
  double max_tilt_rad = 0.85;
  double off_centre_share =
      0.9;  ///< how far out of the picture's middle the sheet's middle goes, of the way to its edge
};

/// \param seed  of the sequence \param index  which of it
CameraPose held_pose(const CameraModel& camera, const Holding& holding, std::uint64_t seed, std::uint64_t index);
/// The same with the sheet parallel to the picture, from 0.5 to 1 m: nothing tells a longer lens from a sheet further
/// away.
CameraPose frontal_pose(std::uint64_t seed, std::uint64_t index);
CameraFromLandmark sheet_before(const CameraPose& pose);
Lens renderer_lens(const CameraModel& camera);

/// As it is printed.
Sheet dot_grid_sheet(const DotGrid& grid);

/// A picture of a sheet, with noise of 1.5 grey levels.
Picture held_picture(const CameraModel& camera, const CameraPose& pose, const Sheet& sheet, std::uint64_t seed);

/// What a perfect search and measurement of a view would give: discs wholly inside of the picture, and points on their
/// outlines with errors of `sigma_px` across them.
SheetView perfect_view(const CameraModel& camera, const CameraPose& pose, std::span<const PlaneDisc> discs,
                       double sigma_px, std::uint64_t seed);

}  // namespace ninedot::test
