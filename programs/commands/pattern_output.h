#pragma once
/// Printed landmarks as a file.
#include <span>
#include <string>

#include "drawing/pattern.h"

namespace ninedot {

/// Writes FILE.svg or FILE.pdf under a temporary name and renames it: never half a file.
/// \param pages  at least one (contract)
/// Throws StartupError: kWrongUsage for another ending, or several pages in an SVG, which has one; kWorkFailed when the
/// file cannot be written.
void write_pattern(std::span<const PatternPage> pages, const std::string& path);

}  // namespace ninedot
