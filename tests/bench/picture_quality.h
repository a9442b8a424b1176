#pragma once
/// How good a picture of the landmark is, measured at the true pose: what the Cramer-Rao bound of that frame needs.
#include <optional>

#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "geometry/transform.h"
#include "image/image_view.h"

namespace ninedot::bench {

struct PictureQuality {
  double contrast_lsb = 0;  ///< median of the paper around P9 less median of P9's middle
  double noise_lsb = 0;     ///< sigma, from second differences on blank paper; 2 where too little of it is visible
  double blur_px = 0;       ///< sigma of the Gaussian that fits P9's outline best; 0.6 where P9 is hidden or tiny
};

/// None where too little of P9 and its surroundings is in the picture, or the contrast is below 5 grey levels.
std::optional<PictureQuality> measure_quality(const ImageView& luma, const CameraModel& camera,
                                              const LandmarkGeometry& landmark,
                                              const Transform<frame::Landmark, frame::Camera>& T_landmark_camera);

/// Where a point of the sheet (X0, Z0) [m] appears; none behind the camera.
std::optional<Eigen::Vector2d> pixel_of_sheet(const CameraModel& camera,
                                              const Transform<frame::Landmark, frame::Camera>& T_landmark_camera,
                                              const Eigen::Vector2d& point_m);

/// Where the ray through a pixel meets the sheet's plane, (X0, Z0) [m]; none where it does not.
std::optional<Eigen::Vector2d> sheet_of_pixel(const CameraModel& camera,
                                              const Transform<frame::Landmark, frame::Camera>& T_landmark_camera,
                                              const Eigen::Vector2d& pixel_px);

}  // namespace ninedot::bench
