#pragma once
/// The renderer's own camera: pixel -> ray -> wall, and the exact truth that tests compare with.
#include <Eigen/Core>

#include "tests/support/renderer.h"

namespace ninedot::test {

/// Where a pixel looks, in the camera frame; its length is free.
struct Ray {
  Eigen::Vector3d direction{0, 0, 1};
  bool valid = false;  ///< the lens sees something there
};

/// Undoes the distortion by a fixed point (equidistant: by Newton's method on the angle).
Ray ray_of_pixel(const Lens& lens, double u_px, double v_px);

/// Columns: the camera's x, y and z axes in S0.
Eigen::Matrix3d rotation_of(const CameraPose& pose);

/// Pixel of the point (X0, 0, Z0): the truth for tests. The point must lie in front of the camera (contract).
Eigen::Vector2d pixel_of_wall_point(const Lens& lens, const CameraPose& pose, double x_m, double z_m);

/// Centroid of the picture of a disc on the wall, from its outline of 720 points, distortion included.
Eigen::Vector2d centroid_of_disc_px(const Lens& lens, const CameraPose& pose, const Disc& disc);

}  // namespace ninedot::test
