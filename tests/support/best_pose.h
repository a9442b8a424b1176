#pragma once
/// The reading that the picture alone speaks for.
#include "base/result.h"
#include "pose/estimate.h"

namespace ninedot::test {

inline Result<PoseEstimate> best_pose(const Result<PoseCandidates>& candidates) {
  if (!candidates) return tl::unexpected<Error>(candidates.error());
  PoseEstimate pose = candidates->list[0].pose;
  pose.ambiguity = ambiguity_of(*candidates, 0);
  return pose;
}

}  // namespace ninedot::test
