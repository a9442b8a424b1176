#pragma once
/// The printed grid of dots for calibrations (geometry/dot_grid.h).
#include <string>

#include "drawing/pattern.h"
#include "geometry/dot_grid.h"

namespace ninedot {

/// The grid in the middle of the paper's upper part, and below it a scale bar and what it is.
/// \param sheet  as parse_sheet takes it
/// Throws StartupError(kWrongUsage): no such paper, or a grid too large for it (the line names the largest pitch).
PatternPage make_grid_page(const DotGrid& grid, const std::string& sheet);

}  // namespace ninedot
