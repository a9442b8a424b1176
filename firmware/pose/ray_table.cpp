#include "pose/ray_table.h"

#include <cmath>
#include <limits>

namespace ninedot {

RayTable::RayTable(const CameraModel& camera) : camera_(camera) {
  if (!camera.has_distortion()) return;
  rays_.resize(2 * static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px));
  float* to = rays_.data();
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const auto ray = camera.normalised_from_pixel({x, y});
      *to++ = ray ? static_cast<float>(ray->x()) : std::numeric_limits<float>::quiet_NaN();
      *to++ = ray ? static_cast<float>(ray->y()) : std::numeric_limits<float>::quiet_NaN();
    }
  }
}

}  // namespace ninedot
