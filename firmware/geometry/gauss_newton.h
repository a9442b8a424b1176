#pragma once
/// Gauss and Newton's method with the problem apart from the loop, and statistics handed back: what the problem looks
/// at may change from stage to stage (other pixels, other weights).
#include <cstdint>

#include "geometry/optimiser_statistics.h"

namespace ninedot {

/// What a problem says of a step that was taken.
enum class StepVerdict : std::uint8_t { kGoOn, kSettled, kUndetermined, kLedNowhere };

/// Problem has
///   using Step = ...;
///   bool linearise(int stage) noexcept;           residuals, Jacobian and weights at its state; false: nothing to see
///   StepVerdict solve(int stage, Step& step) noexcept;   of the normal equations; kGoOn: there is a step
///   StepVerdict take(int stage, const Step& step) noexcept;   moves the state
/// \param first, end  numbers of the stages: [first, end) [1]
template <typename Problem>
OptimiserStatistics gauss_newton(Problem& problem, int first, int end) noexcept {
  OptimiserStatistics statistics;
  for (int stage = first; stage < end; ++stage) {
    typename Problem::Step step;
    StepVerdict verdict = StepVerdict::kUndetermined;
    if (problem.linearise(stage)) {
      verdict = problem.solve(stage, step);
      if (verdict == StepVerdict::kGoOn) {
        ++statistics.iterations;
        verdict = problem.take(stage, step);
      }
    }
    if (verdict == StepVerdict::kGoOn) continue;
    statistics.stopped = verdict == StepVerdict::kSettled      ? Stopped::kSettled
                         : verdict == StepVerdict::kLedNowhere ? Stopped::kLedNowhere
                                                               : Stopped::kUndetermined;
    return statistics;
  }
  return statistics;
}

}  // namespace ninedot
