#pragma once
/// A map as the file that the configuration's key `map` names.
#include <span>
#include <string>

#include "world/landmark_map.h"

namespace ninedot {

/// [[landmarks]] that read_map_text gives back, to a micrometre and 1e-9 of the quaternion; sigmas rounded up, so that
/// a place never becomes exact by rounding, unless it is. Landmarks without a place have none there. \param comment
/// lines for the top of the file, without "# " \param notes    a comment for each landmark, may be empty
std::string format_map(std::span<const MappedLandmark> landmarks, std::span<const std::string> comment,
                       std::span<const std::string> notes);

}  // namespace ninedot
