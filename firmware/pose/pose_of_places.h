#pragma once
/// The pose that suits best where a picture shows the dots, without another look at the picture.
#include <optional>

#include "geometry/dot_sighting.h"
#include "geometry/landmark.h"
#include "geometry/transform.h"
#include "pose/estimate.h"

namespace ninedot {

struct PoseOfPlaces {
  CameraFromLandmark T_camera_landmark;
  /// Of (rotation about the landmark's origin [rad], translation [m]), both along the camera's axes.
  Matrix6d covariance = Matrix6d::Zero();
};

/// Gauss-Newton over the dots' middles, each with its covariance: the pose of greatest likelihood beside the start.
/// What the outlines' shapes say is left out; of a landmark that is small in the picture that is little (method.md, 8).
/// \param dots  those without information are left out
/// \return  none: they determine no pose, or one that is behind the camera Memory: none. Threads: pure.
std::optional<PoseOfPlaces> fit_to_places(const DotSightings& dots, const LandmarkGeometry& landmark,
                                          const CameraFromLandmark& start) noexcept;

}  // namespace ninedot
