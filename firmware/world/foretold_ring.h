#pragma once
/// How well a camera's place, known with an uncertainty, foretells where a landmark of the map appears in the picture.
#include "geometry/landmark.h"
#include "world/place_uncertainty.h"

namespace ninedot {

/// 1-sigma of the rays (x/z, y/z) of the ring's dots, of the dot and the direction where it is largest. To first order:
/// a dot at p before the camera moves by dp = -R^T position + p x rotation. What a pose does not know of a distant
/// landmark's tilt moves camera and landmark together and is not in it.
/// \param covariance  of a PoseStep of `T_world_camera` [m^2, m rad, rad^2]
/// \param place_covariance  of the landmark's place in the map [m^2, m rad, rad^2]
/// \return  [1]; infinity: a dot lies behind the camera
/// Memory: none. Threads: pure.
double foretold_ray_sigma(const WorldFromCamera& T_world_camera, const PoseCovariance& covariance,
                          const WorldFromLandmark& T_world_landmark, const PoseCovariance& place_covariance,
                          const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
