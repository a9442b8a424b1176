#include "programs/commands/calibration_target.h"

#include <fmt/format.h>

#include "calibrate_camera/grid_finder.h"

namespace ninedot {

std::string CalibrationTarget::name() const {
  return grid ? fmt::format("grid of {}x{} dots", grid->columns, grid->rows) : "landmark";
}

std::unique_ptr<SheetFinder> CalibrationTarget::finder(const CameraModel& guess) const {
  if (grid) return std::make_unique<GridFinder>(guess.width_px, guess.height_px, *grid);
  return std::make_unique<LandmarkFinder>(guess, landmark);
}

}  // namespace ninedot
