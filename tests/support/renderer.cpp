// One exposure. A ray per pixel's cell meets the wall; cells that an outline crosses get 8 x 8 of them, each with its
// own cover.
#include "tests/support/renderer.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/contract.h"
#include "tests/support/renderer_film.h"
#include "tests/support/renderer_optics.h"
#include "tests/support/renderer_wall.h"

namespace ninedot::test {
namespace {

constexpr int kSub = 8;             // sub-samples per pixel and axis
constexpr double kFarthest_m = 60;  // beyond is the horizon

// Rays of the picture's pixels and of a margin around it, one row and column more for their derivatives.
class RayGrid {
 public:
  RayGrid(const Scene& scene, int margin_px)
      : relief_(scene.relief),
        width_(scene.lens.width_px + 2 * (margin_px + 1)),
        centre_m_(scene.camera.position_m[0], scene.camera.position_m[1], scene.camera.position_m[2]) {
    const Lens& lens = scene.lens;
    const CameraPose& pose = scene.camera;
    const Eigen::Matrix3d R = rotation_of(pose);
    const int height = lens.height_px + 2 * (margin_px + 1);
    rays_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width_; ++x) {
        Ray ray = ray_of_pixel(lens, x - margin_px - 1, y - margin_px - 1);
        ray.direction = R * ray.direction;
        rays_.push_back(ray);
      }
  }

  // The spot at (x + du, y + dv) px of the margined picture; false where the ray misses the wall.
  bool find_spot(int x, int y, double du_px, double dv_px, Spot& spot) const {
    const Ray &left = at(x, y + 1), &right = at(x + 2, y + 1), &above = at(x + 1, y), &below = at(x + 1, y + 2);
    const Ray& middle = at(x + 1, y + 1);
    if (!middle.valid || !left.valid || !right.valid || !above.valid || !below.valid) return false;
    const Eigen::Vector3d per_u = (right.direction - left.direction) / 2,
                          per_v = (below.direction - above.direction) / 2;
    const Eigen::Vector3d d = middle.direction + du_px * per_u + dv_px * per_v;
    if (d.y() >= -1e-9) return false;
    double reach = -centre_m_.y() / d.y();
    if (reach * d.norm() > kFarthest_m) return false;
    const double slope_x = d.x() / d.y(), slope_z = d.z() / d.y();
    spot.at_m = {centre_m_.x() + reach * d.x(), centre_m_.z() + reach * d.z()};
    if (!relief_.waves.empty()) {
      // Where the ray meets the relief instead: a fixed point, each step a hundredth of the one before.
      for (int i = 0; i < 4; ++i) {
        reach = (relief_.height_m(spot.at_m.x(), spot.at_m.y()) - centre_m_.y()) / d.y();
        spot.at_m = {centre_m_.x() + reach * d.x(), centre_m_.z() + reach * d.z()};
      }
    }
    spot.per_px << reach * (per_u.x() - slope_x * per_u.y()), reach * (per_v.x() - slope_x * per_v.y()),
        reach * (per_u.z() - slope_z * per_u.y()), reach * (per_v.z() - slope_z * per_v.y());
    return true;
  }

 private:
  const Ray& at(int x, int y) const {
    return rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }
  const Relief& relief_;
  int width_;
  Eigen::Vector3d centre_m_;
  std::vector<Ray> rays_;
};

}  // namespace

Exposure expose(const Scene& scene) {
  EXPECTS(scene.camera.position_m[1] > 0 && scene.sensor.point_spread_px >= 0);
  Wall wall(scene);
  const Spread spread(scene.sensor.point_spread_px, kSub);
  const int margin = spread.reach();
  const RayGrid rays(scene, margin);
  const int width = scene.lens.width_px + 2 * margin, height = scene.lens.height_px + 2 * margin;
  Film film(scene.lens.width_px, scene.lens.height_px, spread);
  std::vector<double> flat(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::array<double, kSub * kSub> samples;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double& cell = flat[static_cast<std::size_t>(y * width + x)];
      Spot spot;
      spot.sample_px = kEdgeReach_px;
      if (!rays.find_spot(x, y, 0, 0, spot)) {
        cell = wall.horizon();
        continue;
      }
      cell = wall.light_of_cell(spot);
      if (!spot.edge_near) continue;
      cell = 0;
      for (int j = 0; j < kSub; ++j)
        for (int i = 0; i < kSub; ++i) {
          Spot part;
          part.sample_px = 1.0 / kSub;
          const bool hit = rays.find_spot(x, y, (i + 0.5) / kSub - 0.5, (j + 0.5) / kSub - 0.5, part);
          samples[static_cast<std::size_t>(j * kSub + i)] = hit ? wall.light_of_sample(part) : wall.horizon();
        }
      film.add(x - margin, y - margin, samples);
    }
  film.add_flat(flat);
  return film.take();
}

}  // namespace ninedot::test
