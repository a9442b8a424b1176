#pragma once
/// The sheet that `ninedot calibrate camera` and `calibrate zoom` look for.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibrate_camera/sheet_finder.h"
#include "config/config.h"
#include "geometry/dot_grid.h"

namespace CLI {
class App;
}

namespace ninedot {

/// How it is typed.
struct SheetArguments {
  std::string config;  ///< whose [landmark] says how large the sheet is; empty: the default
  std::string grid;    ///< in place of a landmark; empty: none
  std::string model;   ///< lens model; empty: the simplest that the views support
};

/// Declares --grid and --model. \param arguments  must outlive the command
void add_sheet_options(CLI::App& command, SheetArguments& arguments);

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

/// Throws StartupError(kWrongUsage): no such grid. \param config  what arguments.config holds
CalibrationTarget target_of(const SheetArguments& arguments, const std::optional<Config>& config);

}  // namespace ninedot
