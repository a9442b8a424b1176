#pragma once
/// A map from above, as a picture for people.
#include <cstdint>
#include <span>
#include <string>

#include "world/landmark_map.h"

namespace ninedot {

/// SVG: each landmark as a bar along its sheet with its number behind it, and the ellipse of its 1-sigma in the plane,
/// enlarged by a round number that the picture states. X to the right, Y upwards.
/// \param landmarks  with places (contract: at least one)
/// \param origin     id of the one that is drawn filled [1]
std::string draw_map_plan(std::span<const MappedLandmark> landmarks, std::uint16_t origin);

}  // namespace ninedot
