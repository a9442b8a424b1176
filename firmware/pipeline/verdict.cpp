#include "pipeline/verdict.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

/// Odds of one in 300,000.
constexpr double kExcluded_chi2 = 25;
/// Less than the dead band of the coarsest servos in use, 1 deg.
constexpr double kOnePlace_rad = 0.01;

/// To the landmark's middle, frame camera.
Eigen::Vector3d direction_of(const PoseCandidate& reading) noexcept {
  return reading.pose.T_landmark_camera.inverse().translation_m.normalized();
}

}  // namespace

Reason verdict_on(const PoseEstimate& pose, const TrustLimits& limits) noexcept {
  if (!(pose.ambiguity <= limits.max_ambiguity)) return Reason::kAmbiguous;
  const double sigma_m = std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace());
  if (!(sigma_m <= limits.max_sigma_share * pose.T_landmark_camera.translation_m.norm())) return Reason::kUncertain;
  return Reason::kNone;
}

bool is_place_sure(const PoseCandidates& candidates, std::size_t chosen, Reason verdict, double others_odds,
                   const TrustLimits& limits) noexcept {
  if (verdict == Reason::kNone) return true;
  // A sheet whose tilt is uncertain makes the camera's place so, but hangs where it is seen.
  if (verdict != Reason::kAmbiguous && verdict != Reason::kUncertain) return false;
  if (!(others_odds <= limits.max_ambiguity)) return false;
  const PoseCandidate& believed = candidates.list[chosen];
  const Eigen::Vector3d direction = direction_of(believed);
  return std::ranges::all_of(candidates.list, [&](const PoseCandidate& other) {
    if (other.chi2_above - believed.chi2_above > kExcluded_chi2) return true;
    return other.refined && direction_of(other).cross(direction).norm() < kOnePlace_rad;
  });
}

}  // namespace ninedot
