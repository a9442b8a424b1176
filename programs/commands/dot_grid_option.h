#pragma once
/// --grid of `pattern` and `calibrate camera`.
#include <fmt/format.h>

#include <string>

#include "base/startup_error.h"
#include "geometry/dot_grid.h"

namespace ninedot {

/// Throws StartupError(kWrongUsage): it is none.
inline DotGrid read_dot_grid(const std::string& text) {
  if (const std::optional<DotGrid> grid = parse_dot_grid(text)) return *grid;
  throw StartupError(ExitStatus::kWrongUsage,
                     fmt::format("--grid {}: give COLUMNSxROWS@PITCH, for example 9x7@25: {} to {} dots each way, and "
                                 "their distance in mm",
                                 text, DotGrid::kLeast, DotGrid::kMost));
}

}  // namespace ninedot
