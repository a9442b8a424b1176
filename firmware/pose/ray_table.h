#pragma once
/// The ray of every pixel.
#include <cmath>
#include <cstddef>
#include <vector>

#include "geometry/camera_model.h"

namespace ninedot {

/// Normalised rays of all pixels. Distorted lenses get a table: the inverse is too dear for every pixel of every frame.
/// Memory: the constructor's; one number per column and row without distortion. Threads: const is safe.
class RayTable {
 public:
  explicit RayTable(const CameraModel& camera);
  /// Whether the lens has no inverse for some of the pixels.
  bool has_gaps() const noexcept { return has_gaps_; }
  /// \param ray_x, ray_y  the pixel's ray, z = 1
  /// \return  false where the lens has no inverse
  bool ray(int x, int y, float& ray_x, float& ray_y) const noexcept {
    const std::size_t in_x = index_x(x, y), in_y = index_y(x, y);
    ray_x = x_[in_x], ray_y = y_[in_y];
    return !std::isnan(ray_x);
  }
  /// Of `count` pixels beside each other. \param ray_x, ray_y  at z = 1, not a number where the lens has no inverse [1]
  void rays_of_row(int first_x, int y, std::size_t count, float* ray_x, float* ray_y) const noexcept;

 private:
  std::size_t whole_index(int x, int y) const noexcept {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px_) + static_cast<std::size_t>(x);
  }
  std::size_t index_x(int x, int y) const noexcept {
    return is_distorted_ ? whole_index(x, y) : static_cast<std::size_t>(x);
  }
  std::size_t index_y(int x, int y) const noexcept {
    return is_distorted_ ? whole_index(x, y) : static_cast<std::size_t>(y);
  }

  int width_px_;
  bool is_distorted_, has_gaps_ = false;
  // Of each pixel, not a number where the model has no inverse; of each column and of each row without distortion.
  std::vector<float> x_, y_;
};

}  // namespace ninedot
