#pragma once
/// The most likely place of the camera in one picture under what was foretold.
///
/// A picture enters by its rays and not as a pose: the crest of the posterior is climbed from a start, so that of a
/// sheet that is seen from nearly in front each hypothesis finds its own crest (iterated extended Kalman filter in
/// information form: B. M. Bell, F. W. Cathey, IEEE Trans. Automatic Control 38 (1993) 294-297).
#include <cstddef>
#include <optional>
#include <span>

#include "world/joint_fit.h"

namespace ninedot {

/// The equations of one picture about a place of the camera.
struct FrameFit {
  SightingFit sum;                                              ///< the uncertainty of the sheets' places eliminated
  PoseInformation with_exact_places = PoseInformation::Zero();  ///< sum.normal if there were none [1/m^2, 1/rad^2]
};

/// What one picture shows, all at one instant: sightings with the places of the sheets that they are taken for.
struct FrameView {
  std::span<const JointMember> members;
  const LandmarkGeometry& landmark;

  /// \param turn  index of the members' dot that is P1 here; 0: they are numbered rightly [1]
  FrameFit fit_at(const WorldFromCamera& T_world_camera, std::size_t turn) const noexcept;
};

/// A prediction of the pose as a prior, for all crests of one picture.
struct ForetoldPose {
  WorldFromCamera T_world_camera;
  PoseInformation information = PoseInformation::Zero();  ///< zero: nothing was foretold [1/m^2, 1/rad^2]
  double log_density = 0;                                 ///< half the logarithm of its determinant [1]
  PoseCovariance covariance = PoseCovariance::Zero();     ///< with what pictures have in common [m^2, m rad, rad^2]
};

struct Crest {
  WorldFromCamera T_world_camera;
  FrameFit fit;                                        ///< there, of the picture alone
  PoseCovariance covariance = PoseCovariance::Zero();  ///< of prediction and picture together [m^2, m rad, rad^2]
  PoseStep moved = PoseStep::Zero();                   ///< from the foretold pose [m, rad]
  PoseStep apart = PoseStep::Zero();                   ///< from here to the picture's own crest, foretold [m, rad]
  double surprise_chi2 = 0;                            ///< of picture against prediction; six freedoms [1]
  double alone_chi2 = 0;                               ///< the least that the picture alone would have near here [1]
  double log_motion = 0;  ///< logarithm of what the motion says of this crest, its volume included [1]
};

/// Climbs from `start`. None: the picture does not show from there what it should, or leaves freedoms open.
/// \param turn  see FrameView::fit_at [1] \param own_share  of the sightings' variance what is this picture's own, > 0
/// \param max_surprise_chi2  above it the crest may be given with a surprise that is too large [1]
/// Memory: none. Threads: pure.
std::optional<Crest> climb(const FrameView& frame, std::size_t turn, double own_share, const ForetoldPose& foretold,
                           const WorldFromCamera& start, double max_surprise_chi2) noexcept;

/// Cholesky's factor of an information that may leave freedoms open.
/// \param information  [1/m^2] of positions, [1/rad^2] of rotations
Eigen::LLT<PoseInformation> root_of(const PoseInformation& information) noexcept;

}  // namespace ninedot
