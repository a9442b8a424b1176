#pragma once
/// From refined outlines to a pose with its uncertainty.
#include <array>

#include "base/result.h"
#include "geometry/camera_model.h"
#include "image/noise.h"
#include "pose/estimate.h"
#include "pose/outline_refiner.h"
#include "pose/pose_of_places.h"

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
  /// Its dots may have colours: a tone curve moves their outlines less than a black one's, by 0.05 of a radius of 2 px,
  /// so that they differ in size, and P9, which is black, from all of them.
  bool is_coloured = false;
};
inline constexpr double kForetoldMisfit_px = 0.25;  ///< where a map and a track say that it is there

/// Another reading of the same dots, which their places alone were asked for. \param seen  what was read first: light,
/// blur and what is visible are the same \return  its `chi2_above` is still that of `seen`
/// Memory: none. Threads: pure.
PoseCandidate candidate_of(const PoseOfPlaces& other, const PoseCandidate& seen, const CameraModel& camera,
                           const LandmarkGeometry& landmark) noexcept;

/// Dots that are in sight, in part at least (kMinVisible). 0..9 [1] \param visible_share  of each dot's outline, 0..1
/// Memory: none. Threads: pure.
int dots_in_sight(const std::array<double, kDotCount>& visible_share) noexcept;
/// With so many or fewer a wrong pose may fit nearly all of what is in sight: they are judged more strictly. [1]
inline constexpr int kFewDots = 6;

/// Whether all dots of the ring are there, each as a whole: what fits no picture then is something else that looks like
/// the landmark, and not the landmark hidden in part. Memory: none. Threads: pure.
bool has_whole_ring(const PoseCandidate& candidate) noexcept;

/// Whether the picture's grey levels agree with a pose, judged by the picture's own noise: something that only
/// resembles a landmark leaves residuals of an eighth of its contrast and more, however well its outlines fit each
/// other. Measured: docs/method.md, section 9. \param noise  of the same picture Memory: none. Threads: pure.
bool fits_picture(const PoseCandidate& candidate, const PictureNoise& noise,
                  const FitAllowance& allowance = {}) noexcept;

/// Why a pose is of no use, if it is. \param most_sigma  of the position, as a share of the distance [1]
/// \error kNoLandmark: the outlines do not lie where those of one landmark would. kPoseDegenerate: too little is
/// visible.
Result<void> check_pose(const PoseEstimate& pose, const CameraModel& camera, const LandmarkGeometry& landmark,
                        double most_sigma) noexcept;

}  // namespace ninedot
