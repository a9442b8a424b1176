#pragma once
/// From which sum of squares on a measurement is taken for wrong.
#include <cmath>

namespace ninedot {

/// A test that rejects a true measurement once in a million: in a building with 50,000 sightings none, as a rule.
inline constexpr double kFalseAlarm = 1e-6;          ///< probability [1]
inline constexpr double kFalseAlarm_sigma = 4.7534;  ///< the normal distribution is above it with kFalseAlarm [1]

/// What a chi-square variable exceeds with the probability kFalseAlarm. Wilson & Hilferty, "The distribution of
/// chi-square", PNAS 17 (1931): its cube root is nearly normal; up to 4 % above the true quantile at 6 degrees of
/// freedom and more, 1 % at 18. \param freedoms  >= 1
inline double chi2_limit(int freedoms) noexcept {
  const double spread = 2.0 / (9.0 * freedoms);
  return freedoms * std::pow(1 - spread + kFalseAlarm_sigma * std::sqrt(spread), 3);
}

/// The median, by the same approximation. \param freedoms  > 0, need not be whole [1]
/// \return  [1]
inline double chi2_median(double freedoms) noexcept { return freedoms * std::pow(1 - 2.0 / (9.0 * freedoms), 3); }

}  // namespace ninedot
