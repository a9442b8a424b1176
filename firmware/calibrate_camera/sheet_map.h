#pragma once
/// From a sheet to the picture of it, one view's, whatever the lens.
#include <Eigen/Core>
#include <functional>
#include <span>

#include "calibrate_camera/sheet_view.h"
#include "detect/homography.h"
#include "geometry/camera_model.h"
#include "geometry/transform.h"

namespace ninedot {

/// Where a sheet point (X0, Z0) [m] is seen [px].
using SheetMap = std::function<Eigen::Vector2d(const Eigen::Vector2d& plane_m)>;

/// A homography through the centroids: what is known of a view before the lens is. \param H  sheet [m] to picture [px]
/// \return  false: fewer than five discs, or they lie on a line
bool fit_sheet_map(std::span<const SeenDisc> seen, std::span<const PlaneDisc> discs, Eigen::Matrix3d& H) noexcept;

/// A disc and its surroundings by such a homography, moved to where the disc is seen: the lens moves a disc as a whole
/// by many pixels, but bends one little. \param H  sheet [m] to picture [px]
SheetMap map_of_disc(const Eigen::Matrix3d& H, const PlaneDisc& disc, const Eigen::Vector2d& centre_px);

/// Once the lens is known.
SheetMap map_of_camera(const CameraModel& camera, const CameraFromLandmark& T_camera_landmark);

}  // namespace ninedot
