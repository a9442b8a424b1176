#pragma once
/// The other pose from which a flat landmark looks almost alike.
#include <array>

#include "geometry/dot_sighting.h"
#include "geometry/landmark.h"
#include "geometry/transform.h"

namespace ninedot {

/// Visible shares of a landmark that nothing hides [1].
inline constexpr std::array<double, kDotCount> kAllInSight{1, 1, 1, 1, 1, 1, 1, 1, 1};

/// As much inclined to the other side of the line of sight: alike but for perspective. Memory: none. Threads: pure.
CameraFromLandmark reflected(const CameraFromLandmark& T_camera_landmark) noexcept;

/// The pose from which the dots' centres look most like those of `T`, on the other side of the line of sight: what the
/// reflection of `T` there becomes when it is fitted to the centres as `T` shows them. Where perspective leaves these a
/// single solution, the reflection itself: noise in a picture can have made a second one all the same, and `T` of it.
/// \param visible_share  of each dot's outline, 0..1: the poses are to look alike where dots are in sight
/// (kMinVisible), unless fewer than five are; what is hidden may move as it likes. Of half a landmark that is another
/// pose than of all. Memory: none. Threads: pure.
CameraFromLandmark mirror_image(const CameraFromLandmark& T_camera_landmark, const LandmarkGeometry& landmark,
                                const std::array<double, kDotCount>& visible_share = kAllInSight) noexcept;

/// The most that one picture can say for one of two poses against the other by where it shows their dots. Two readings
/// whose dots lie d apart differ by a chi^2 of D^2 = sum of d^T C^-1 d, give or take 2 D (a likelihood ratio of two
/// Gaussians); what goes beyond that comes of what no model has.
/// \param dots  C^-1 of each \param pattern  1-sigma of each dot's ray, beside C [1]
/// \return  D^2 + 2 D, difference of chi^2 [1] Memory: none. Threads: pure.
double evidence_of_places(const CameraFromLandmark& a, const CameraFromLandmark& b, const DotSightings& dots,
                          double pattern, const LandmarkGeometry& landmark) noexcept;

/// What the places where one picture shows the dots do say for `a` against `b`. \param dots  their places and the
/// information of each \return  difference of chi^2 [1], above zero where `a` suits them better Memory: none. Threads:
/// pure.
double preference_of_places(const CameraFromLandmark& a, const CameraFromLandmark& b, const DotSightings& dots,
                            const LandmarkGeometry& landmark) noexcept;

/// Angle of the rotation between two poses. 0..pi
double angle_between_rad(const CameraFromLandmark& a, const CameraFromLandmark& b) noexcept;

/// Two poses closer than this are one: a quarter of a degree is less than the sigma of any pose that has a mirror image
/// to be confused with.
inline constexpr double kSamePose_rad = 0.005;

}  // namespace ninedot
