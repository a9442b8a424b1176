#pragma once
/// Where each pixel of the simulated camera looks: worked out once, from the lens's equations alone.
#include <Eigen/Core>
#include <vector>

#include "geometry/camera_model.h"

namespace ninedot {

/// Pixel of a point of the camera frame. Of `camera` only the numbers are used, none of its functions.
/// \param point  at z = 1 [1]
/// \return  [px]; beyond the field that the lens was calibrated for it means nothing
/// Memory: none. Threads: pure.
Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector2d& point) noexcept;

/// Memory: everything is allocated by the constructor. Threads: never changed afterwards.
class RayField {
 public:
  /// Pixels around the picture that have rays as well: a blurred pixel at its edge has light from there.
  static constexpr int kBorder_px = 8;

  struct Ray {
    float x = 0, y = 0;  ///< at z = 1 [1]; not a number where the lens sees nothing
  };

  explicit RayField(const CameraModel& camera);

  int width_px() const noexcept { return width_px_; }
  int height_px() const noexcept { return height_px_; }
  /// The rays of a row, from column -kBorder_px to width + kBorder_px - 1. \param v  likewise of the rows
  const Ray* row(int v) const noexcept {
    return rays_.data() + static_cast<std::ptrdiff_t>(v + kBorder_px) * (width_px_ + 2 * kBorder_px) + kBorder_px;
  }
  /// No ray of the picture is farther from the optical axis [1, at z = 1].
  double farthest() const noexcept { return farthest_; }

 private:
  int width_px_, height_px_;
  std::vector<Ray> rays_;
  double farthest_ = 0;
};

}  // namespace ninedot
