#pragma once
/// How much of a sample lies inside of an outline painted on a wall.
///
/// Along outlines, distances in the wall become distances in pixels through J, the local map of the cell, and the cover
/// of a sample is that of a straight edge through a square of the sample's size.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tests/support/renderer.h"

namespace ninedot::test {

/// A place on the wall, (X0, Z0), and the size of a sample there.
struct Spot {
  Eigen::Vector2d at_m{0, 0};
  Eigen::Matrix2d per_px = Eigen::Matrix2d::Zero();  ///< J = d(at_m) / d(pixel)
  double sample_px = 1;                              ///< side of the sample
  bool edge_near = false;                            ///< set below: an outline crosses the sample
};

/// Samples of this side [px] tell which cells have to be sub-sampled: an edge lies within half of it from the middle.
constexpr double kEdgeReach_px = 1.7;

/// Part of the sample on the inner side of an outline, from the distance to it in the wall (negative inside) and the
/// outline's unit normal there.
inline double cover(Spot& spot, double distance_m, const Eigen::Vector2d& normal, double softness_m = 0) {
  const double m_per_px = (spot.per_px.transpose() * normal).norm();
  const double width_m = std::max(spot.sample_px * m_per_px, softness_m);
  const double inside = std::clamp(0.5 - distance_m / width_m, 0.0, 1.0);
  if (inside > 0 && inside < 1) spot.edge_near = true;
  return inside;
}

/// |distance| < half: what is inside both edges = inside of one + inside of the other - 1, right for strokes thinner
/// than a sample too.
inline double cover_between(Spot& spot, double distance_m, double half_m, const Eigen::Vector2d& normal,
                            double softness_m = 0) {
  return std::max(0.0, cover(spot, distance_m - half_m, normal, softness_m) +
                           cover(spot, -distance_m - half_m, normal, softness_m) - 1);
}

/// A rectangle anywhere in the wall: |along| < half_length, |across| < half_width.
inline double cover_of_rectangle(Spot& spot, const Eigen::Vector2d& middle_m, const Eigen::Vector2d& along,
                                 double half_length_m, double half_width_m) {
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d offset_m = spot.at_m - middle_m;
  return cover_between(spot, offset_m.dot(along), half_length_m, along) *
         cover_between(spot, offset_m.dot(across), half_width_m, across);
}

inline double cover_of_disc(Spot& spot, const Eigen::Vector2d& middle_m, double radius_m) {
  const Eigen::Vector2d offset_m = spot.at_m - middle_m;
  const double rho_m = offset_m.norm();
  return cover(spot, rho_m - radius_m, rho_m > 0 ? Eigen::Vector2d(offset_m / rho_m) : Eigen::Vector2d::UnitX());
}

/// Reflectance of a smooth random pattern; octaves finer than two pixels are left out.
double textured(const Texture& texture, const Spot& spot);

}  // namespace ninedot::test
