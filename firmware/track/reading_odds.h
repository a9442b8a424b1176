#pragma once
/// How likely it is that another reading of a picture than the chosen one is right.
///
/// One picture of a flat ring of equal dots can be read in sixteen ways: two planar solutions times eight numberings.
/// What the grey levels say of a reading is its chi^2, what the camera's mount says of it is upright_prior.h; with
/// equal prior odds the posterior of reading i is exp(-cost_i / 2) over their sum (Bayes).
#include "geometry/upright_prior.h"
#include "pose/estimate.h"

namespace ninedot {

struct ReadingOdds {
  double ambiguity = 0;               ///< the odds of all readings but the chosen one together, 0..1
  double mirror_weight = 0;           ///< of the other planar solution, in units of the chosen reading's weight [1]
  std::optional<RivalReading> rival;  ///< the likeliest of the others
};

/// \param candidates  what the solver answered \param chosen  index of the one that is believed
/// \param numbering_past  what a track's way has said against each numbering already; 0 for all: nothing [1]
/// \param upright  how the camera is mounted; null: `numbering_past` alone tells the numberings apart
/// \return  a planar solution within the chosen one's covariance (95 %) is none of its own and counts as no other
/// Memory: none. Threads: pure.
ReadingOdds weigh_readings(const PoseCandidates& candidates, std::size_t chosen, const NumberingCosts& numbering_past,
                           const LandmarkGeometry& landmark, const UprightPrior* upright) noexcept;

}  // namespace ninedot
