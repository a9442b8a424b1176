#pragma once
/// From the configuration's millimetres and degrees to the metres and radians of who follows the camera in the world.
#include "config/config.h"
#include "geometry/body.h"
#include "track/pose_filter.h"

namespace ninedot {

/// [track], with the geometry that all landmarks share.
PoseFilterOptions pose_filter_options(const Config& config);

/// [body].
BodyGeometry body_geometry(const BodyConfig& config);

}  // namespace ninedot
