#pragma once
/// How a sheet is held before a camera, as far as one picture tells without its lens.
#include <Eigen/Core>
#include <optional>
#include <span>

#include "calibrate_camera/sheet_view.h"

namespace ninedot {

struct SheetAttitude {
  Eigen::Vector2d middle_px{0, 0};  ///< where the sheet's middle is seen
  double height_share = 0;          ///< of the picture's height: what the discs span the way that is not shortened [1]
  double tilt_rad = 0;         ///< between the sheet and the picture's plane, from how much shorter one way is seen
  Eigen::Vector2d away{0, 0};  ///< unit vector in the picture towards where the sheet is furthest [1]
};

/// By the homography of a view: exact for a lens without distortion in the picture's middle, good to tell 30 degrees
/// from none anywhere else. \return  nothing: fewer than five discs, or they lie on a line
/// Memory: allocates. Threads: pure.
std::optional<SheetAttitude> attitude_of(std::span<const SeenDisc> seen, std::span<const PlaneDisc> discs,
                                         int height_px);

}  // namespace ninedot
