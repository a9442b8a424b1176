#pragma once
/// Bundle adjustment: the places of landmarks and cameras that explain all sightings best together.
///
/// B. Triggs et al., "Bundle Adjustment - A Modern Synthesis", 1999; solved by Ceres Solver with the cameras eliminated
/// first (Schur complement).
#include <functional>

#include "mapping/sighting_network.h"

namespace ninedot {

struct AdjustmentOptions {
  /// Cauchy's loss: a sighting, or a surveyed place, whose chi-square is above this many times its limit loses its
  /// influence [1]. Infinite: none does.
  double tolerance = 1;
  int max_iterations = 50;
  std::function<void()> progress;  ///< called after every step; may be empty
};

/// Moves what `network` counts, from where it is. \return  half the loss at the end [1]
double adjust(SightingNetwork& network, const AdjustmentOptions& options);

/// What pictures say against a surveyed place, as a chi-square of six freedoms. \pre it has one (contract) [1]
double chi2_of_survey(const NetworkLandmark& landmark) noexcept;

/// Inverse covariance of a surveyed place; what is given as exact is so to a hundredth of a millimetre and a hundredth
/// of a degree. [1/m^2, 1/(m rad), 1/rad^2]
PlaceCovariance survey_information(const MappedLandmark& surveyed) noexcept;

}  // namespace ninedot
