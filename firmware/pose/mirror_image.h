#pragma once
/// The other pose from which a flat landmark looks almost alike.
#include "geometry/landmark.h"
#include "geometry/transform.h"

namespace ninedot {

/// The pose from which the dots' centres look most like those of `T`, on the other side of the line of sight: the other
/// solution of Collins & Bartoli, IJCV 2014, for the centres as `T` shows them. Where perspective leaves these a single
/// solution, the reflection: noise in a picture can have made a second one all the same, and `T` of it.
/// Memory: none. Threads: pure.
CameraFromLandmark mirror_image(const CameraFromLandmark& T_camera_landmark, const LandmarkGeometry& landmark) noexcept;

/// Angle of the rotation between two poses. 0..pi
double angle_between_rad(const CameraFromLandmark& a, const CameraFromLandmark& b) noexcept;

/// Two poses closer than this are one: a quarter of a degree is less than the sigma of any pose that has a mirror image
/// to be confused with.
inline constexpr double kSamePose_rad = 0.005;

}  // namespace ninedot
