#pragma once
/// What printed sheets have in common beside the sheet itself.
#include <string>
#include <vector>

#include "drawing/pattern.h"

namespace ninedot {

inline constexpr double kScaleBar_mm = 100;

/// A ruler of kScaleBar_mm, to check that a printer keeps lengths. \param left  its left end
void add_scale_bar(PatternPage& page, const PagePoint& left);

/// Words below each other. \param first  where the first line's base line starts
void add_lines(PatternPage& page, PagePoint first, const std::vector<std::string>& lines);

}  // namespace ninedot
