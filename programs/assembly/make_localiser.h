#pragma once
/// The frame processor that a map asks for.
#include <memory>

#include "geometry/camera_model.h"
#include "pipeline/localiser.h"

namespace ninedot {

/// Coded landmarks or several; else one black-and-white one.
bool is_room(const LandmarkMap& map) noexcept;

/// One black-and-white landmark has a processor that knows of no other; coded ones and several have one that asks which
/// they are. Memory: allocates, at the start.
std::unique_ptr<FrameProcessor> make_localiser(const CameraModel& camera, const LocaliserOptions& options);

}  // namespace ninedot
