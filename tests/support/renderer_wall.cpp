#include "tests/support/renderer_wall.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot::test {
namespace {

Eigen::Vector2d heading(double direction_rad) { return {std::cos(direction_rad), std::sin(direction_rad)}; }

}  // namespace

double Wall::Mark::cover_at(Spot& spot) const {
  return round ? cover_of_disc(spot, middle_m, reach_m)
               : cover_of_rectangle(spot, middle_m, along, half_length_m, half_width_m);
}

Wall::Mark Wall::rectangle(const Eigen::Vector2d& middle_m, const Eigen::Vector2d& along, double length_m,
                           double width_m, double reflectance) {
  return {middle_m, std::hypot(length_m, width_m) / 2, reflectance, false, along, length_m / 2, width_m / 2};
}

Wall::Wall(const Scene& scene) : scene_(scene) {
  for (const Sheet& sheet : scene.sheets) {
    const Eigen::Vector2d middle_m(sheet.x_m, sheet.z_m);
    if (sheet.width_m > 0 && sheet.height_m > 0)
      marks_.push_back(rectangle(middle_m, Eigen::Vector2d::UnitX(), sheet.width_m, sheet.height_m, sheet.reflectance));
    for (const Disc& d : sheet.discs)
      marks_.push_back({middle_m + Eigen::Vector2d(d.x_m, d.z_m), d.radius_m, d.reflectance});
    for (const Bar& b : sheet.bars) {
      const Eigen::Vector2d from_m(b.x0_m, b.z0_m), to_m(b.x1_m, b.z1_m);
      const double length_m = (to_m - from_m).norm();
      marks_.push_back(
          rectangle(middle_m + (from_m + to_m) / 2, (to_m - from_m) / length_m, length_m, b.width_m, b.reflectance));
    }
  }
  if (scene.board.hidden_fraction > 0) {
    EXPECTS(!scene.sheets.empty());
    const Eigen::Vector2d normal = heading(scene.board.direction_rad);
    const Eigen::Vector2d sheet_m(scene.sheets[0].x_m, scene.sheets[0].z_m);
    const double edge_m = board_offset_m(scene.board, scene.sheets[0]) - sheet_m.dot(normal);
    board_ = rectangle(sheet_m + (edge_m + scene.board.width_m / 2) * normal, normal, scene.board.width_m,
                       scene.board.length_m, 0);
  }
  near_.reserve(marks_.size());
}

double Wall::light_of_cell(Spot& spot) {
  near_.clear();
  const double margin_m = spot.sample_px * spot.per_px.norm();
  for (const Mark& mark : marks_) {
    const double reach_m = mark.reach_m + margin_m;
    if ((spot.at_m - mark.middle_m).squaredNorm() < reach_m * reach_m) near_.push_back(&mark);
  }
  return light_of_sample(spot);
}

double Wall::light_of_sample(Spot& spot) const {
  const double hidden = scene_.board.hidden_fraction > 0 ? board_.cover_at(spot) : 0;
  double light = 0;
  if (hidden < 1) light += (1 - hidden) * reflectance_at(spot) * irradiance(spot);
  if (hidden > 0) light += hidden * textured(scene_.board.texture, spot) * scene_.light.level;
  return (1 - scene_.haze.veil) * light + scene_.haze.veil * scene_.haze.level;
}

double Wall::reflectance_at(Spot& spot) const {
  double value = -1;  // the texture is evaluated only where it shows
  for (const Mark* mark : near_) {
    const double part = mark->cover_at(spot);
    if (part <= 0) continue;
    if (value < 0 && part < 1) value = textured(scene_.wall, spot);
    value = part < 1 ? value + part * (mark->reflectance - value) : mark->reflectance;
  }
  return value < 0 ? textured(scene_.wall, spot) : value;
}

double Wall::irradiance(Spot& spot) const {
  const Light& light = scene_.light;
  double factor = std::max(0.02, 1 + light.gradient_x_per_m * spot.at_m.x() + light.gradient_z_per_m * spot.at_m.y());
  for (const Shadow& shadow : light.shadows) {
    const Eigen::Vector2d normal = heading(shadow.direction_rad);
    const double d_m = spot.at_m.dot(normal) - shadow.offset_m;
    const double inside = cover_between(spot, d_m, shadow.width_m / 2, normal, shadow.penumbra_m);
    factor *= 1 - inside * (1 - shadow.remaining);
  }
  return light.level * factor;
}

}  // namespace ninedot::test
