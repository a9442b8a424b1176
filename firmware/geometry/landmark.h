#pragma once
/// The nine-dot landmark: eight equal dots P1..P8 on a circle around P9.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <numbers>

namespace ninedot {

inline constexpr std::size_t kRingDotCount = 8;  ///< of the landmark of Martin & Adan, Pattern Recognition 45 (2012)
inline constexpr std::size_t kDotCount = 9;      ///< and P9 in their middle
inline constexpr std::size_t kCentreDot = 8;     ///< index of P9; indices 0..7 are P1..P8

/// Lengths of one landmark, all > 0. Defaults: the sheet of 210 x 210 mm that `ninedot pattern` prints.
struct LandmarkGeometry {
  double ring_radius_m = 0.080;
  double dot_radius_m = 0.0127;
  double centre_radius_m = 0.0254;

  /// White paper reaches this far from the middle of P9 along both of the sheet's axes (the square that `ninedot
  /// pattern` prints leaves nearly a dot's radius around the ring; A4 is no wider). Beyond it there may be anything.
  double paper_radius_m() const noexcept { return ring_radius_m + (1 + kWhite_radii) * dot_radius_m; }
  /// From a dot's outline to the nearest side of that square, straight [m].
  double white_beside_m(std::size_t dot) const noexcept {
    return paper_radius_m() - centre_m(dot).cwiseAbs().maxCoeff() - radius_m(dot);
  }
  static constexpr double kWhite_radii = 12.3 / 12.7;  ///< at the default size 12.3 mm: the sheet's side is 210 mm

  double radius_m(std::size_t dot) const noexcept { return dot == kCentreDot ? centre_radius_m : dot_radius_m; }

  /// Middle of a dot in the sheet's plane: (X0, Z0) [m], Y0 = 0.
  /// Pk = R (sin a, -cos a) with a = 45 deg (k - 1): P1 lowest, clockwise as the viewer sees it (X0 points to his
  /// left).
  Eigen::Vector2d centre_m(std::size_t dot) const noexcept {
    if (dot == kCentreDot) return Eigen::Vector2d::Zero();
    constexpr double kDiagonal = std::numbers::sqrt2 / 2;
    constexpr std::array<double, kRingDotCount> kSine{0, kDiagonal, 1, kDiagonal, 0, -kDiagonal, -1, -kDiagonal};
    return ring_radius_m * Eigen::Vector2d(kSine[dot], -kSine[(dot + 2) % kRingDotCount]);
  }
};

}  // namespace ninedot
