#pragma once
/// Where in the picture to look for a landmark, and for spots of which size.
#include <Eigen/Core>
#include <optional>

#include "detect/blob_finder.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "image/image_view.h"

namespace ninedot {

/// A part of the picture, all of it inside, and levels of the pyramid.
struct SearchArea {
  int x_px = 0, y_px = 0, width_px = 0, height_px = 0;
  BlobFinder::Levels levels;

  ImageView cut(const ImageView& luma) const noexcept {
    return {luma.row(y_px) + x_px, width_px, height_px, luma.stride_bytes};
  }
};

/// The box around all outlines with a margin for the motion between two frames, and the levels that see the dots best.
/// \param H_ray_plane  sheet [m] to bearing (z = 1), as in LandmarkObservation
/// \return  none: not in the picture, not before the camera, or not a number
/// Memory: none. Threads: pure.
std::optional<SearchArea> search_area_around(const Eigen::Matrix3d& H_ray_plane, const CameraModel& camera,
                                             const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
