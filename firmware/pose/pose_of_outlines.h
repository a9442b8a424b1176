#pragma once
/// From refined outlines to a pose with its uncertainty.
#include "base/result.h"
#include "geometry/camera_model.h"
#include "image/noise.h"
#include "pose/estimate.h"
#include "pose/outline_refiner.h"

namespace ninedot {

/// \param refiner  that has converged
/// \return  without a shape, which costs a stage: who has searched asks the refiner for it
/// Memory: none. Threads: pure.
PoseCandidate candidate_of(const OutlineRefiner& refiner, const CameraModel& camera,
                           const LandmarkGeometry& landmark) noexcept;

/// What is known of a landmark beside this picture, so that less of it has to tell that it is one.
struct FitAllowance {
  /// Of the dots' places, beside what is allowed to what nobody expects. [px] A colour camera's pattern and its
  /// interpolation move dots of two or three pixels by 0.2 to 0.35 px (rendered rooms, 5 to 6.4 m).
  double misfit_px = 0;
  /// Of the dots' sizes, in dot radii [1]: a tone curve moves the outline of a coloured dot less than that of a black
  /// one, by 0.05 of a radius of 2 px.
  double size = 0;
};
inline constexpr double kForetoldMisfit_px = 0.25;  ///< where a map and a track say that it is there
inline constexpr double kColouredSize = 0.04;       ///< where its dots may have colours [1]

/// Whether the picture's grey levels agree with a pose, judged by the picture's own noise: something that only
/// resembles a landmark leaves residuals of an eighth of its contrast and more, however well its outlines fit each
/// other. Measured: docs/method.md, section 9. \param noise  of the same picture Memory: none. Threads: pure.
bool fits_picture(const PoseCandidate& candidate, const PictureNoise& noise,
                  const FitAllowance& allowance = {}) noexcept;

/// Why a pose is of no use, if it is.
/// \error kNoLandmark: the outlines do not lie where those of one landmark would. kPoseDegenerate: too little is
/// visible.
Result<void> check_pose(const PoseEstimate& pose, const CameraModel& camera, const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
