#pragma once
/// From the configuration's millimetres and degrees to the localiser's metres and radians.
#include "config/config.h"
#include "pipeline/localiser.h"

namespace ninedot {

/// Throws StartupError(kWrongUsage) when the map asks for what this version cannot tell apart: colour codes, or more
/// than one black-and-white landmark.
LocaliserOptions localiser_options(const Config& config);

}  // namespace ninedot
