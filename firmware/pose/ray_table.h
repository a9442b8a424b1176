#pragma once
/// The ray of every pixel.
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
  bool ray(int x, int y, float& ray_x, float& ray_y) const noexcept;

 private:
  CameraModel camera_;
  std::vector<float> rays_;  // x, y of each pixel; NaN where the model has no inverse
};

}  // namespace ninedot
