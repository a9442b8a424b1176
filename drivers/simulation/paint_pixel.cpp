#include "drivers/simulation/paint_pixel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/simulation/sheet_renderer.h"

namespace ninedot {
namespace {

constexpr int kCells = 4;  // across a pixel
constexpr double kCell_px = 1.0 / kCells;
constexpr int kCentre = 8;

/// P1 is the lowest, the others follow clockwise; X points to the viewer's left, Z up.
const std::array<Eigen::Vector2d, 8>& ring() noexcept {
  static const std::array<Eigen::Vector2d, 8> directions = [] {
    std::array<Eigen::Vector2d, 8> list;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const double angle = std::numbers::pi / 4 * static_cast<double>(i);
      list[i] = {std::sin(angle), -std::cos(angle)};
    }
    return list;
  }();
  return directions;
}

/// Share of a cell on the near side of an edge. \param beyond_px  from the edge to the middle of the cell
double near_share(double beyond_px) noexcept { return std::clamp(0.5 - beyond_px / kCell_px, 0.0, 1.0); }

}  // namespace

bool PixelPainter::hits(const PixelRay& ray, Spot& spot) const noexcept {
  const Eigen::Vector3d p = H_ * ray.at.homogeneous();
  if (!(p.z() > 1e-4)) return false;  // behind, or 10 km away
  spot.at = p.head<2>() / p.z();
  const Eigen::Matrix2d per_ray = (H_.topLeftCorner<2, 2>() - spot.at * H_.bottomLeftCorner<1, 2>()) / p.z();
  spot.per_px.col(0) = per_ray * ray.per_column;
  spot.per_px.col(1) = per_ray * ray.per_row;
  return true;
}

void PixelPainter::add(const PixelRay& ray, PixelCover& cover) const noexcept {
  Spot spot;
  if (!hits(ray, spot)) return;
  // Half a pixel along both axes, and a tenth for what is not linear.
  const Eigen::Vector2d reach_m = 0.6 * spot.per_px.cwiseAbs().rowwise().sum();
  const Eigen::Vector2d inside_m = sheet_->half_side_m - spot.at.cwiseAbs().array();
  if ((inside_m + reach_m).minCoeff() < 0) return;
  const Dot dot = dot_near(spot, reach_m.sum());
  if ((inside_m - reach_m).minCoeff() < 0 || dot.is_crossed) return add_edges(ray, spot, dot, cover);
  cover.paper += 1;
  if (dot.index >= 0) add_dot(dot, 1, cover);
}

PixelPainter::Dot PixelPainter::dot_near(const Spot& spot, double reach_m) const noexcept {
  Dot dot;
  const double distance_m = spot.at.norm();
  const auto take = [&](int index, const Eigen::Vector2d& middle, double radius_m, double off_m) {
    dot = {index, middle, radius_m, off_m > radius_m - reach_m};
  };
  if (distance_m < sheet_->centre_radius_m + reach_m) {
    take(kCentre, Eigen::Vector2d::Zero(), sheet_->centre_radius_m, distance_m);
  } else if (std::abs(distance_m - sheet_->ring_radius_m) < sheet_->dot_radius_m + reach_m) {
    for (int i = 0; i < kCentre; ++i) {
      const Eigen::Vector2d middle = sheet_->ring_radius_m * ring()[static_cast<std::size_t>(i)];
      const double square = (spot.at - middle).squaredNorm(), limit_m = sheet_->dot_radius_m + reach_m;
      if (square < limit_m * limit_m) take(i, middle, sheet_->dot_radius_m, std::sqrt(square));
    }
  }
  return dot;
}

void PixelPainter::add_dot(const Dot& dot, float share, PixelCover& cover) const noexcept {
  const Reflectance& ink = sheet_->inks[static_cast<std::size_t>(dot.index)];
  cover.ink += share;
  cover.light[0] += share * ink.red;
  cover.light[1] += share * ink.green;
  cover.light[2] += share * ink.blue;
}

void PixelPainter::add_edges(const PixelRay& ray, const Spot& spot, const Dot& dot, PixelCover& cover) const noexcept {
  const Eigen::Vector2d per_px = spot.per_px.rowwise().norm();  // across the paper's two pairs of edges
  double paper = 0, ink = 0;
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const Eigen::Vector2d direction =
          ray.at + ((i + 0.5) * kCell_px - 0.5) * ray.per_column + ((j + 0.5) * kCell_px - 0.5) * ray.per_row;
      const Eigen::Vector3d p = H_ * direction.homogeneous();
      const Eigen::Vector2d at = p.head<2>() / p.z();
      const Eigen::Vector2d beyond_px = (at.cwiseAbs().array() - sheet_->half_side_m) / per_px.array();
      const double on_paper = near_share(beyond_px.x()) * near_share(beyond_px.y());
      paper += on_paper;
      if (dot.index < 0) continue;
      const Eigen::Vector2d off = at - dot.middle;
      const double off_m = off.norm();
      const double m_per_px = (spot.per_px.transpose() * off).norm() / std::max(off_m, 1e-12);
      ink += on_paper * near_share((off_m - dot.radius_m) / std::max(m_per_px, 1e-12));
    }
  constexpr double kShare = 1.0 / (kCells * kCells);
  cover.paper += static_cast<float>(paper * kShare);
  if (dot.index >= 0) add_dot(dot, static_cast<float>(ink * kShare), cover);
}

}  // namespace ninedot
