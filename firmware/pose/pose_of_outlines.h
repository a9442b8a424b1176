#pragma once
/// From refined outlines to a pose with its uncertainty.
#include "base/result.h"
#include "geometry/camera_model.h"
#include "image/noise.h"
#include "pose/estimate.h"
#include "pose/outline_refiner.h"

namespace ninedot {

/// \param refiner  that has converged \param look_at_shape  whether these are discs: for what is not tracked already
/// Memory: none. Threads: pure.
PoseCandidate candidate_of(const OutlineRefiner& refiner, const CameraModel& camera, const LandmarkGeometry& landmark,
                           bool look_at_shape) noexcept;

/// Whether the picture's grey levels agree with a pose, judged by the picture's own noise: something that only
/// resembles a landmark leaves residuals of an eighth of its contrast and more, however well its outlines fit each
/// other. Measured: docs/method.md, section 9. \param noise  of the same picture Memory: none. Threads: pure.
bool fits_picture(const PoseCandidate& candidate, const PictureNoise& noise) noexcept;

/// Why a pose is of no use, if it is.
/// \error kNoLandmark: the outlines do not lie where those of one landmark would. kPoseDegenerate: too little is
/// visible.
Result<void> check_pose(const PoseEstimate& pose, const CameraModel& camera, const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
