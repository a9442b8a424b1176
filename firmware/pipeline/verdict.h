#pragma once
/// Whether a pose may be acted on.
#include "base/reason.h"
#include "pose/estimate.h"

namespace ninedot {

struct TrustLimits {
  double max_ambiguity = 0.01;    ///< odds of another reading of the picture, 0..1
  double max_sigma_share = 0.03;  ///< 1-sigma of the position, all axes together, of the distance, 0..1
};

/// \param pose  one that fits the picture (pose_of_outlines.h)
/// \return  kNone: yes; kAmbiguous, kUncertain: why not, the first that holds
/// Memory: none. Threads: pure.
Reason verdict_on(const PoseEstimate& pose, const TrustLimits& limits) noexcept;

/// Whether a head may turn to the landmark, though nobody may act on its pose: its readings, mirror images and
/// numberings, have its middle in one direction.
/// \param chosen  index of the reading that is believed \param verdict  on that \param others_odds  that it is another
/// landmark, 0..1
/// Memory: none. Threads: pure.
bool is_place_sure(const PoseCandidates& candidates, std::size_t chosen, Reason verdict, double others_odds,
                   const TrustLimits& limits) noexcept;

}  // namespace ninedot
