#include "track/reading_odds.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/renumbered.h"

namespace ninedot {
namespace {

constexpr double kCertain_log = 300;   // of odds: what is more, the other way, would be no finite number
constexpr double kWithin_chi2 = 12.6;  // of six freedoms: 95 % of what the covariance allows

bool is_within_covariance(const PoseEstimate& chosen, const PoseEstimate& other) noexcept {
  Vector6d apart;
  apart << other.T_landmark_camera.translation_m - chosen.T_landmark_camera.translation_m,
      log_so3(chosen.T_landmark_camera.rotation.transpose() * other.T_landmark_camera.rotation);
  return apart.dot(chosen.covariance.ldlt().solve(apart)) < kWithin_chi2;
}

}  // namespace

ReadingOdds weigh_readings(const PoseCandidates& candidates, std::size_t chosen, const NumberingCosts& numbering_past,
                           const LandmarkGeometry& landmark, const UprightPrior* upright) noexcept {
  const auto numbering_of = [&](const PoseCandidate& candidate) {
    NumberingCosts costs{};
    if (upright != nullptr) costs = upright_costs(candidate.pose.T_landmark_camera.inverse(), landmark, *upright);
    for (std::size_t k = 0; k < costs.size(); ++k) costs[k] = std::max(costs[k], numbering_past[k]);
    return costs;
  };
  const PoseCandidate& believed = candidates.list[chosen];
  const double own_cost = numbering_of(believed)[0];
  ReadingOdds odds;
  double others = 0, likeliest = 0;
  for (std::size_t i = 0; i < candidates.list.size(); ++i) {
    const PoseCandidate& candidate = candidates.list[i];
    const bool is_own = i == chosen || is_within_covariance(believed.pose, candidate.pose);
    const double side_chi2 = i == chosen ? 0 : std::abs(candidate.chi2_above - believed.chi2_above);
    if (i != chosen && is_own) continue;
    const NumberingCosts costs = numbering_of(candidate);
    for (std::size_t k = 0; k < costs.size(); ++k) {
      if (is_own && k == 0) continue;
      const double weight = std::exp(std::min(-0.5 * (side_chi2 + costs[k] - own_cost), kCertain_log));
      others += weight;
      if (!is_own && k == 0) odds.mirror_weight = weight;
      if (weight <= likeliest) continue;
      likeliest = weight;
      odds.rival =
          RivalReading{renumbered(candidate.pose.T_landmark_camera.inverse(), static_cast<int>(k)).inverse(), weight};
    }
  }
  odds.ambiguity = others / (1 + others);
  if (odds.rival) odds.rival->odds /= 1 + others;
  return odds;
}

}  // namespace ninedot
