#include "detect/observation.h"

#include <Eigen/Geometry>
#include <numbers>

namespace ninedot {

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

}  // namespace ninedot
