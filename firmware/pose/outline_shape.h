#pragma once
/// Whether what was fitted are discs of the landmark's sizes: what the outlines leave when the pose is right.
#include <array>
#include <cmath>

#include "pose/estimate.h"
#include "pose/outline_sums.h"

namespace ninedot {

/// Of a disc on the sheet as the camera sees it, short semi-axis over long one, 0..1: the cosine of the angle between
/// the sheet's normal and the ray to its middle. Memory: none. Threads: pure.
inline double foreshortening(const CameraFromLandmark& T_camera_landmark) noexcept {
  return std::abs(T_camera_landmark.rotation.col(1).dot(T_camera_landmark.translation_m.normalized()));
}

/// Semi-axes of an ellipse [px], both above 0. Of a dot seen from aside most of the outline runs along the long one:
/// another shape moves it by a share of the short one.
struct DotAxes {
  double semi_major_px, semi_minor_px;
  double mean_px() const noexcept { return std::sqrt(semi_major_px * semi_minor_px); }  ///< radius of a disc as large
};

/// How far the outlines lie from those of discs, beyond what noise makes of them.
/// \param visible_share  of each dot's outline, 0..1: the others have no shape
/// \param noise_variance_lsb2  of one pixel [LSB^2]
/// \param dot  of the ring
/// \return  `absent`, `hollow` and `spots` are left 0
/// Memory: none. Threads: pure.
OutlineShape shape_of_outlines(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state,
                               const std::array<double, kDotCount>& visible_share, double noise_variance_lsb2,
                               const DotAxes& dot) noexcept;

/// Dots of the ring that nothing hides: printed elsewhere, one or two in a row, each with paper in a part of its place
/// and ink beside it; or three and more with nothing but paper in their places. And P9, seen or not, with paper on one
/// side of its place and ink beyond the other.
/// \param visible_share  of each dot's outline, 0..1 \param fit  of the outlines that are there
/// Memory: none. Threads: pure.
int count_absent(const ImageView& luma, const CameraModel& camera, const LandmarkGeometry& landmark,
                 const CameraFromLandmark& T_camera_landmark, const std::array<double, kDotCount>& visible_share,
                 const OutlineFit& fit) noexcept;

/// Dots in sight whose middle is paper: washers, holes with a rim. Only those that blur leaves a middle.
/// \param blur_px  sigma of the point spread [px] Memory: none. Threads: pure.
int count_hollow(const ImageView& luma, const CameraModel& camera, const LandmarkGeometry& landmark,
                 const CameraFromLandmark& T_camera_landmark, const std::array<double, kDotCount>& visible_share,
                 const OutlineFit& fit, double blur_px) noexcept;

/// Spots of ink with paper all around between P9 and the ring, where the sheet is blank; 0 where a dot is not whole,
/// for what hides it may be spotted. A cable that lies across is one at most, and a shadow none. Memory: none. Threads:
/// pure.
int count_spots(const ImageView& luma, const CameraModel& camera, const LandmarkGeometry& landmark,
                const CameraFromLandmark& T_camera_landmark, const std::array<double, kDotCount>& visible_share,
                const OutlineFit& fit) noexcept;

}  // namespace ninedot
