#pragma once
/// The ray of every pixel.
#include <cmath>
#include <cstddef>
#include <vector>

#include "geometry/camera_model.h"

namespace ninedot {

/// Normalised rays of all pixels. Distorted lenses get a table: the inverse is too dear for every pixel of every frame.
/// Memory: the constructor's; none without distortion. Threads: const is safe.
class RayTable {
 public:
  explicit RayTable(const CameraModel& camera);
  /// \param ray_x, ray_y  the pixel's ray, z = 1
  /// \return  false where the lens has no inverse
  bool ray(int x, int y, float& ray_x, float& ray_y) const noexcept {
    if (rays_.empty()) {
      ray_x = static_cast<float>((x - camera_.cx_px) / camera_.fx_px);
      ray_y = static_cast<float>((y - camera_.cy_px) / camera_.fy_px);
      return true;
    }
    const std::size_t at =
        2 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width_px) + static_cast<std::size_t>(x));
    ray_x = rays_[at];
    ray_y = rays_[at + 1];
    return !std::isnan(ray_x);
  }

 private:
  CameraModel camera_;
  std::vector<float> rays_;  // x, y of each pixel; NaN where the model has no inverse
};

}  // namespace ninedot
