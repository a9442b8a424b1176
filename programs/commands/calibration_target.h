#pragma once
/// The sheet that `ninedot calibrate camera` looks for.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibrate_camera/sheet_finder.h"
#include "geometry/dot_grid.h"

namespace ninedot {

/// A landmark, or a grid of dots.
struct CalibrationTarget {
  LandmarkGeometry landmark;
  std::optional<DotGrid> grid;  ///< in place of the landmark
  std::vector<PlaneDisc> discs;

  /// "landmark" or "grid of 9x7 dots".
  std::string name() const;
  /// Who finds it. \param guess  of the lens; a grid needs none but for the pictures' size
  std::unique_ptr<SheetFinder> finder(const CameraModel& guess) const;
};

}  // namespace ninedot
