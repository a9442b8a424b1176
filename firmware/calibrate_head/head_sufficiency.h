#pragma once
/// Whether stops are enough to calibrate a head, and what is missing where they are not.
#include <string>
#include <vector>

#include "base/units.h"
#include "calibrate_head/head_calibration.h"

namespace ninedot {

/// Less of a turn of either axis moves the camera by less than a third of its lever, and does not tell a length.
inline constexpr double kLeastTravel_rad = 20 * kRadPerDeg;

/// What can be said before any fit: no angles, a head that hardly moved, too few stops, a landmark that is not there or
/// moves.
/// \return  a line each; none: go on
std::vector<std::string> what_stops_lack(const FoundStops& found);

/// What the calibration itself says: stops that contradict each other, numbers that are too uncertain.
/// \return  a line each; none: it may be used
std::vector<std::string> what_head_lacks(const HeadCalibration& calibration);

}  // namespace ninedot
