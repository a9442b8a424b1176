#pragma once
/// The physical limit of a position measured from one picture: the Cramer-Rao bound.
#include "tests/bench/picture_quality.h"

namespace ninedot::bench {

/// 1-sigma of the camera's position, all axes together [m], that no unbiased estimator which knows the intrinsics can
/// undercut: square root of the trace of the position's block of (J^T J)^-1 noise^2.
///
/// Picture model: paper and nine discs seen through the camera model (distortion included), outlines blurred by a
/// Gaussian, independent Gaussian noise per pixel. J are the derivatives of all pixels by the six pose parameters and
/// by paper, ink and blur, which an estimator has to find out as well. Nothing hidden: for a partly hidden landmark the
/// bound is too low. \return  0 where the landmark's visible part does not determine a pose
double position_bound_m(const CameraModel& camera, const LandmarkGeometry& landmark,
                        const Transform<frame::Landmark, frame::Camera>& T_landmark_camera,
                        const PictureQuality& quality);

}  // namespace ninedot::bench
