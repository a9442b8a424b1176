#include "programs/commands/calibration_target.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "calibrate_camera/grid_finder.h"
#include "programs/assembly/localiser_options.h"
#include "programs/commands/dot_grid_option.h"

namespace ninedot {

void add_sheet_options(CLI::App& command, SheetArguments& arguments) {
  command.add_option(
      "--grid", arguments.grid,
      "COLUMNSxROWS@PITCH in mm: a printed grid of dots in place of a landmark (`ninedot pattern --grid`)");
  command.add_option("--model", arguments.model, "lens model; default: the simplest that foretells views well")
      ->check(CLI::IsMember({"plumb_bob", "rational_polynomial", "equidistant"}));
}

CalibrationTarget target_of(const SheetArguments& arguments, const std::optional<Config>& config) {
  CalibrationTarget target;
  if (!arguments.grid.empty()) {
    target.grid = read_dot_grid(arguments.grid);
    target.discs = discs_of(*target.grid);
    return target;
  }
  if (config) target.landmark = localiser_options(*config).seeker.landmark;
  target.discs = discs_of(target.landmark);
  return target;
}

std::string CalibrationTarget::name() const {
  return grid ? fmt::format("grid of {}x{} dots", grid->columns, grid->rows) : "landmark";
}

std::unique_ptr<SheetFinder> CalibrationTarget::finder(const CameraModel& guess) const {
  if (grid) return std::make_unique<GridFinder>(guess.width_px, guess.height_px, *grid);
  return std::make_unique<LandmarkFinder>(guess, landmark);
}

}  // namespace ninedot
