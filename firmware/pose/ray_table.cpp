#include "pose/ray_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ninedot {

RayTable::RayTable(const CameraModel& camera) : width_px_(camera.width_px), is_distorted_(camera.has_distortion()) {
  if (!is_distorted_) {
    for (int x = 0; x < camera.width_px; ++x) x_.push_back(static_cast<float>((x - camera.cx_px) / camera.fx_px));
    for (int y = 0; y < camera.height_px; ++y) y_.push_back(static_cast<float>((y - camera.cy_px) / camera.fy_px));
    return;
  }
  const auto count = static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px);
  x_.reserve(count), y_.reserve(count);
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const auto ray = camera.normalised_from_pixel({x, y});
      x_.push_back(ray ? static_cast<float>(ray->x()) : std::numeric_limits<float>::quiet_NaN());
      y_.push_back(ray ? static_cast<float>(ray->y()) : std::numeric_limits<float>::quiet_NaN());
      has_gaps_ |= !ray;
    }
  }
}

void RayTable::rays_of_row(int first_x, int y, std::size_t count, float* ray_x, float* ray_y) const noexcept {
  std::copy_n(&x_[index_x(first_x, y)], count, ray_x);
  if (is_distorted_)
    std::copy_n(&y_[index_y(first_x, y)], count, ray_y);
  else
    std::fill_n(ray_y, count, y_[index_y(first_x, y)]);
}

}  // namespace ninedot
