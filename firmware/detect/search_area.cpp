#include "detect/search_area.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "detect/homography.h"

namespace ninedot {
namespace {

/// The levels that see the ring's dots (narrower way) and P9 (wider way) at 2 to 20 of their pixels.
BlobFinder::Levels levels_for(const Eigen::Matrix3d& H_ray_plane, const CameraModel& camera,
                              const LandmarkGeometry& landmark) noexcept {
  double narrow_px = 1e9, wide_px = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Matrix2d J = jacobian_of_map(H_ray_plane, landmark.centre_m(dot));
    const double size_px = 2 * landmark.radius_m(dot) * camera.fx_px;
    const double product = std::abs(J.determinant());
    const double largest = J.norm();
    narrow_px = std::min(narrow_px, size_px * product / std::max(largest, 1e-12));
    wide_px = std::max(wide_px, size_px * largest);
  }
  BlobFinder::Levels levels{0, 0};
  // A level is left out while dots are wider than 8 px of the next one, and the last is the first that sees P9 at no
  // more than 14 of its pixels: both in the middle of the 2 to 20 that a level is made for.
  constexpr int kFine_px = 8, kCoarse_px = 14;
  while (levels.first < BlobFinder::kLevels - 1 && narrow_px > kFine_px * (2 << levels.first)) ++levels.first;
  levels.last = levels.first;
  while (levels.last < BlobFinder::kLevels - 1 && wide_px > kCoarse_px * (1 << levels.last)) ++levels.last;
  return levels;
}

}  // namespace

std::optional<SearchArea> search_area_around(const Eigen::Matrix3d& H_ray_plane, const CameraModel& camera,
                                             const LandmarkGeometry& landmark) noexcept {
  constexpr int kDirections = 16;  // of the circle around all dots: between two it bulges by 2 % of its radius
  // Of the box, on every side. A robot that drives up at 1 m/s moved a side of the box by 0.10 of its width at most
  // between two frames at 35 Hz (true poses of the recording `motion`), and by 0.28 over three (`approach`): two frames
  // may be lost.
  constexpr double kMargin = 0.3;
  // For distant landmarks: half the threshold's square (24 px of its level) beside a dot must be in the box.
  constexpr double kLeastMargin_px = SpotThreshold::kSquare_px;
  // The coarsest level halves four times: one pixel is left of that.
  constexpr int kLeastSide_px = 1 << BlobFinder::kLevels;
  const double inf = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(inf, inf), high(-inf, -inf);
  const double reach_m = landmark.ring_radius_m + landmark.dot_radius_m;
  for (int i = 0; i < kDirections; ++i) {
    const double a_rad = i * 2 * std::numbers::pi / kDirections;
    const Eigen::Vector2d plane_m = reach_m * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad));
    if (!((H_ray_plane * plane_m.homogeneous()).z() > 0)) return std::nullopt;
    const Eigen::Vector2d px = camera.pixel_from_normalised(map_point(H_ray_plane, plane_m));
    if (!px.allFinite()) return std::nullopt;
    low = low.cwiseMin(px), high = high.cwiseMax(px);
  }
  const Eigen::Vector2d margin = (kMargin * (high - low)).cwiseMax(kLeastMargin_px);
  const auto within = [](double at_px, int side_px) {
    return static_cast<int>(std::clamp(at_px, 0.0, static_cast<double>(side_px)));
  };
  SearchArea area;
  area.x_px = within(low.x() - margin.x(), camera.width_px);
  area.y_px = within(low.y() - margin.y(), camera.height_px);
  area.width_px = within(high.x() + margin.x() + 1, camera.width_px) - area.x_px;
  area.height_px = within(high.y() + margin.y() + 1, camera.height_px) - area.y_px;
  if (area.width_px < kLeastSide_px || area.height_px < kLeastSide_px) return std::nullopt;
  area.levels = levels_for(H_ray_plane, camera, landmark);
  return area;
}

}  // namespace ninedot
