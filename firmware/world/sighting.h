#pragma once
/// What one picture says of where one landmark is before the camera, in the form in which many landmarks and many
/// pictures can be joined.
///
/// A pose with its covariance will not do for that: seen from nearly in front, a small landmark's tilt enters the
/// picture by its square, its likelihood has two crests, and no Gaussian over the pose has more than one. Over the
/// places of its dots in the picture the likelihood is a Gaussian: whoever joins sightings projects the dots by the
/// pose in question and gets both crests for nothing.
#include <cstdint>

#include "geometry/dot_sighting.h"
#include "geometry/transform.h"

namespace ninedot {

/// With the shutter's rolling taken out: all of it at the frame's own instant.
struct LandmarkSighting {
  std::uint16_t id = 0;                  ///< of the map
  CameraFromLandmark T_camera_landmark;  ///< the landmark's own best pose
  DotSightings dots;
  /// 1-sigma of a turn of the camera, each axis, between its place and the rows that show this landmark: it moves all
  /// of their rays alike, and nothing of where they lie about each other [rad].
  double turn_sigma_rad = 0;
};

}  // namespace ninedot
