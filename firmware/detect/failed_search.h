#pragma once
/// What a search of the whole picture saw and took for no landmark: for whoever asks why nothing was found.
#include <algorithm>
#include <array>
#include <span>

#include "base/refusal.h"
#include "detect/blob.h"
#include "detect/observation.h"

namespace ninedot {

/// Of an outline, dark inside and bright outside: the dot is there, whole (12 of the 16 directions in which it is
/// looked at) [1].
inline constexpr float kSeenOutline = 0.75F;

struct FailedSearch {
  std::span<const Blob> spots;  ///< all that could have been a dot, the largest first; until the next search
  /// Of the guess that came nearest to a landmark: the first thing that speaks against it. kNone: there was no guess.
  Refusal refusal = Refusal::kNone;
  /// Where that guess has the dots; `seen` where an outline is there. Numbered in turn, from any of them.
  std::array<DotObservation, kDotCount> dots{};
  double contrast_lsb = 0;  ///< of ink and paper there
  double noise_lsb = 0;     ///< of the picture, 1-sigma

  /// Whether the guess is worth showing: in any room some two spots lie like a part of a ring, somehow.
  bool has_guess() const noexcept {
    return refusal != Refusal::kNone &&
           std::ranges::count_if(dots, [](const DotObservation& d) { return d.seen; }) >= 3;
  }
};

}  // namespace ninedot
