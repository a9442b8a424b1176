#pragma once
/// Where the camera was, from what one picture shows of landmarks whose places are taken as known.
#include <span>

#include "base/inline_vector.h"
#include "geometry/landmark.h"
#include "world/sighting_fit.h"

namespace ninedot {

struct PlacedSighting {
  const LandmarkSighting* seen = nullptr;  ///< not null (contract)
  WorldFromLandmark T_world_landmark;
};

struct CameraFit {
  WorldFromCamera T_world_camera;
  double chi2 = 0;  ///< of all dots seen, two each [1]; infinite: no such place
};

/// The place that explains the sightings best, near `start`. Levenberg and Marquardt's method.
/// Memory: none. Threads: pure.
CameraFit fit_camera(std::span<const PlacedSighting> sightings, const WorldFromCamera& start,
                     const LandmarkGeometry& landmark) noexcept;

/// One way in which a sighting can be read by itself.
struct OwnPose {
  CameraFromLandmark T_camera_landmark;
  double chi2 = 0;  ///< of its dots [1]
  /// Inverse information of the camera's place in the landmark's frame, as a PoseStep. [m^2, m rad, rad^2]
  PoseInformation covariance = PoseInformation::Zero();
};

/// The best first; a second where the sighting has a mirror image that is not out of the question.
using OwnPoses = InlineVector<OwnPose, 2>;

/// \return  empty: fewer than four dots, or no pose explains them
/// Memory: none. Threads: pure.
OwnPoses own_poses(const LandmarkSighting& sighting, const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
