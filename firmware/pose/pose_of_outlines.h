#pragma once
/// From refined outlines to a pose with its uncertainty.
#include "base/result.h"
#include "geometry/camera_model.h"
#include "pose/estimate.h"
#include "pose/outline_refiner.h"

namespace ninedot {

/// \param refiner  that has converged
/// Memory: none. Threads: pure.
PoseCandidate candidate_of(const OutlineRefiner& refiner, const CameraModel& camera,
                           const LandmarkGeometry& landmark) noexcept;

/// Why a pose is of no use, if it is.
/// \error kNoLandmark: the outlines do not lie where those of one landmark would. kPoseDegenerate: too little is
/// visible.
Result<void> check_pose(const PoseEstimate& pose, const CameraModel& camera, const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
