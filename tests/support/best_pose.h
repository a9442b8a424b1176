#pragma once
/// The reading that the picture alone speaks for.
#include <cmath>

#include "base/result.h"
#include "pose/estimate.h"

namespace ninedot::test {

/// The odds, 0..1, that another reading than the chosen one is right, by the picture alone: exp(-chi^2 / 2) of their
/// difference; 0 where there is no other. \param chosen  index of the chosen one in the list
inline double ambiguity_of(const PoseCandidates& candidates, std::size_t chosen) noexcept {
  double ambiguity = 0;
  for (std::size_t i = 0; i < candidates.list.size(); ++i)
    if (i != chosen)
      ambiguity = std::fmax(
          ambiguity, std::exp(-0.5 * std::abs(candidates.list[i].chi2_above - candidates.list[chosen].chi2_above)));
  return ambiguity;
}

inline Result<PoseEstimate> best_pose(const Result<PoseCandidates>& candidates) {
  if (!candidates) return tl::unexpected<Error>(candidates.error());
  PoseEstimate pose = candidates->list[0].pose;
  pose.ambiguity = ambiguity_of(*candidates, 0);
  return pose;
}

}  // namespace ninedot::test
