#pragma once
/// How far a pose that is seen from nearly in front may be off.
///
/// Foreshortening tells the square of a tilt, perspective its sign, and from some metres on perspective tells little:
/// the likelihood has two crests, which melt into a single flat one where the tilt comes near zero. The curvature at
/// its top says nothing of its width then.
#include "geometry/dot_sighting.h"
#include "pose/estimate.h"

namespace ninedot {

/// The second moment about a pose of all poses by their likelihood, over the two freedoms of the tilt; `covariance`
/// where the other crest is apart, which is a reading of its own then (track/reading_odds.h).
/// \param T_camera_landmark  the crest \param dots  what its outlines say
/// \param covariance  by the curvature there, of a step: rotation about the landmark's origin [rad], translation [m],
/// frame camera \return likewise [rad, m]
/// Memory: none. Threads: pure.
Matrix6d covariance_over_tilts(const CameraFromLandmark& T_camera_landmark, const DotSightings& dots,
                               const LandmarkGeometry& landmark, const Matrix6d& covariance) noexcept;

}  // namespace ninedot
