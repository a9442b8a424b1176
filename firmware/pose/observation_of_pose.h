#pragma once
/// What a detector would hand over of a landmark whose pose is known.
#include <array>

#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "geometry/transform.h"
#include "pose/estimate.h"

namespace ninedot {

/// \param visible_share  of each dot's outline, 0..1; from kMinVisible on a dot counts as seen
/// Memory: none. Threads: pure.
LandmarkObservation observation_of(const CameraFromLandmark& T_camera_landmark,
                                   const std::array<double, kDotCount>& visible_share, const CameraModel& camera,
                                   const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
