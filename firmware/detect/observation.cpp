#include "detect/observation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace ninedot {

void set_outline(const Eigen::Matrix2d& moments_px2, DotObservation& dot) noexcept {
  const double mean = 0.5 * (moments_px2(0, 0) + moments_px2(1, 1));
  const double half = 0.5 * (moments_px2(0, 0) - moments_px2(1, 1));
  const double spread = std::hypot(half, moments_px2(0, 1));
  dot.semi_major_px = 2 * std::sqrt(mean + spread);
  dot.semi_minor_px = 2 * std::sqrt(std::max(mean - spread, 0.0));
  dot.angle_rad = 0.5 * std::atan2(2 * moments_px2(0, 1), 2 * half);
}

LandmarkObservation renumbered(const LandmarkObservation& seen, int eighths) noexcept {
  constexpr int kCount = kRingDotCount;
  const auto first = static_cast<std::size_t>((eighths % kCount + kCount) % kCount);
  LandmarkObservation out = seen;
  if (first == 0) return out;
  for (std::size_t k = 0; k < kRingDotCount; ++k) {
    out.dots[k] = seen.dots[(k + first) % kRingDotCount];
    out.numbering_chi2[k] = seen.numbering_chi2[(k + first) % kRingDotCount];
  }
  // New coordinates X' of the same point: old = turn * new, where turn carries P1 to where dot `first` was.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(static_cast<double>(first) * std::numbers::pi / 4).toRotationMatrix();
  out.H_ray_plane = seen.H_ray_plane * turn;
  return out;
}

bool is_same_reading(const LandmarkObservation& a, const LandmarkObservation& b,
                     const LandmarkGeometry& landmark) noexcept {
  constexpr double kSameShare = 0.001;
  const auto ray = [&](const LandmarkObservation& seen, std::size_t dot) -> Eigen::Vector2d {
    return (seen.H_ray_plane * landmark.centre_m(dot).homogeneous()).hnormalized();
  };
  const double size =
      (ray(a, 0) - ray(a, kRingDotCount / 2)).norm() + (ray(a, 2) - ray(a, 2 + kRingDotCount / 2)).norm();
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (a.dots[dot].seen != b.dots[dot].seen || !((ray(a, dot) - ray(b, dot)).norm() < kSameShare * size / 2))
      return false;
  return true;
}

}  // namespace ninedot
