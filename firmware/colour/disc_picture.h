#pragma once
/// Where a disc of the sheet appears in the picture, and how much of a spot it covers.
#include <Eigen/Core>
#include <algorithm>

#include "geometry/camera_model.h"
#include "geometry/transform.h"

namespace ninedot {

/// How a sheet moves through the picture while that is exposed.
struct PictureMotion {
  Eigen::Vector2f line_px{0, 0};     ///< what each point of it draws, from end to end; 0: a point [px]
  Eigen::Vector2f per_row_px{0, 0};  ///< how much farther on it is in each row than in the one above it [px]
};

/// A disc of the sheet in the picture, up to the second order of its size: an ellipse, and the sheet around it.
struct DiscPicture {
  Eigen::Vector2f centre_px{0, 0};  ///< of the outline, lens distortion included
  Eigen::Matrix2f px_per_radius;    ///< from the sheet, in radii of the disc, to the picture [px]
  Eigen::Matrix2f radius_per_px;    ///< and back [1/px]
  float semi_major_px = 0, semi_minor_px = 0;

  /// How far inside the outline a spot is, in the picture, to the first order of the distance; negative: outside [px].
  /// \param on_sheet  the spot, in radii of the disc [1]
  float inside_px(const Eigen::Vector2f& on_sheet) const noexcept {
    const float rho = on_sheet.norm();
    const float gradient = (radius_per_px.transpose() * on_sheet).norm();  // rho times its gradient in the picture
    return gradient > 0 ? (1 - rho) * rho / gradient : semi_minor_px;
  }
  /// Share of light that a spot of the picture gets from the disc. \param inside_px  as above \param blur_px  1-sigma
  /// of what a sample sees, per axis [px] \return  0..1
  float cover(float inside_px, float blur_px) const noexcept {
    // Phi(inside / blur) over the plane is pi (r^2 + blur^2), while blur leaves the disc's light pi r^2 as it is: the
    // peak of a small disc is lower by that.
    const float area = semi_major_px * semi_minor_px;
    return normal_step(inside_px / blur_px) * area / (area + blur_px * blur_px);
  }

  /// Phi(z), the normal distribution, by the cubic step with the same slope in its middle: within 0.02 of it.
  /// \param z  [1] \return  0..1
  static float normal_step(float z) noexcept {
    constexpr float kHalfWidth = 1.88F;  // 1.5 / (2 phi(0))
    const float u = std::clamp(0.5F + z / (2 * kHalfWidth), 0.0F, 1.0F);
    return u * u * (3 - 2 * u);
  }
};

/// \param centre_m  (X0, Z0) of its middle \param radius_m  > 0
/// \return  semi_minor_px = 0: it is not before the camera, or seen from behind or edgewise
/// Memory: none. Threads: pure.
DiscPicture disc_in_picture(const CameraFromLandmark& T_camera_landmark, const CameraModel& camera,
                            const Eigen::Vector2d& centre_m, double radius_m) noexcept;

}  // namespace ninedot
