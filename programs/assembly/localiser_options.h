#pragma once
/// From the configuration's millimetres and degrees to the localiser's metres and radians.
#include "config/config.h"
#include "pipeline/localiser.h"
#include "world/landmark_map.h"

namespace ninedot {

/// Where the configuration has it; the world's origin where it has no place.
Transform<frame::World, frame::Landmark> place_of(const MapLandmarkConfig& landmark);

/// The [[landmarks]] with their places and uncertainties; where there are none LandmarkMap's own. A lone landmark whose
/// place is not told hangs at the world's origin.
LandmarkMap landmark_map(const Config& config);

LocaliserOptions localiser_options(const Config& config);

}  // namespace ninedot
