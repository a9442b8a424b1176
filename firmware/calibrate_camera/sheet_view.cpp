#include "calibrate_camera/sheet_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calibrate_camera/sheet_map.h"

namespace ninedot {
namespace {

/// Around the discs, in radii of the largest: what the lens bends, and the white that an outline needs beside it.
constexpr double kMargin_radii = 2;
constexpr int kMargin_px = 12;

}  // namespace

std::vector<PlaneDisc> discs_of(const LandmarkGeometry& landmark) {
  std::vector<PlaneDisc> discs;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) discs.push_back({landmark.centre_m(dot), landmark.radius_m(dot)});
  return discs;
}

SheetView keep_view(const ImageView& luma, SensorKind sensor, std::vector<SeenDisc> seen,
                    std::span<const PlaneDisc> discs) {
  SheetView view;
  view.seen = std::move(seen);
  view.noise = PictureNoise(luma);
  Eigen::Matrix3d H;
  if (view.seen.size() < 4 || !fit_sheet_map(view.seen, discs, H)) return view;
  // Also of the discs that were not found: the picture's border may cut them.
  Eigen::Vector2d low = view.seen.front().centre_px, high = low;
  for (const PlaneDisc& disc : discs) {
    const double reach_px = kMargin_px + kMargin_radii * disc.radius_m * jacobian_of_map(H, disc.centre_m).norm();
    const Eigen::Vector2d centre_px = map_point(H, disc.centre_m);
    if (!centre_px.allFinite() || (H * disc.centre_m.homogeneous()).z() * H(2, 2) <= 0) continue;
    low = low.cwiseMin((centre_px.array() - reach_px).matrix());
    high = high.cwiseMax((centre_px.array() + reach_px).matrix());
  }
  PictureCrop& crop = view.picture;
  crop.sensor = sensor;
  const auto inside = [](double px, int end) {
    return static_cast<int>(std::clamp(px, 0.0, static_cast<double>(end)));
  };
  crop.left_px = inside(low.x(), luma.width_px - 1);
  crop.top_px = inside(low.y(), luma.height_px - 1);
  crop.width_px = inside(std::ceil(high.x()) + 1, luma.width_px) - crop.left_px;
  crop.height_px = inside(std::ceil(high.y()) + 1, luma.height_px) - crop.top_px;
  crop.pixels.reserve(static_cast<std::size_t>(crop.width_px) * static_cast<std::size_t>(crop.height_px));
  for (int y = 0; y < crop.height_px; ++y) {
    const std::uint8_t* row = luma.row(crop.top_px + y) + crop.left_px;
    crop.pixels.insert(crop.pixels.end(), row, row + crop.width_px);
  }
  return view;
}

double distance_px(const SheetView& a, const SheetView& b) {
  double sum_px = 0;
  int common = 0;
  for (const SeenDisc& one : a.seen)
    for (const SeenDisc& other : b.seen)
      if (one.disc == other.disc) sum_px += (one.centre_px - other.centre_px).norm(), ++common;
  return common >= 4 ? sum_px / common : std::numeric_limits<double>::infinity();
}

}  // namespace ninedot
