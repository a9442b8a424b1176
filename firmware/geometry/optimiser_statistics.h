#pragma once
/// How an optimiser fared.
#include <cstdint>

namespace ninedot {

/// Why an optimiser stopped.
enum class Stopped : std::uint8_t {
  kSettled,       ///< the last step was too short to matter
  kOutOfStages,   ///< it was still moving, by less and less
  kUndetermined,  ///< what is visible determines no step
  kLedNowhere,    ///< the problem gave up: the start was not where it was said to be
};

struct OptimiserStatistics {
  int iterations = 0;  ///< steps tried
  Stopped stopped = Stopped::kOutOfStages;

  /// The state is a solution, if perhaps one that would still have moved a little.
  bool has_converged() const noexcept { return stopped == Stopped::kSettled || stopped == Stopped::kOutOfStages; }
};

}  // namespace ninedot
