#pragma once
/// What a search of the whole picture saw and took for no landmark: for whoever asks why nothing was found.
#include <array>
#include <span>

#include "base/refusal.h"
#include "detect/blob.h"
#include "detect/observation.h"

namespace ninedot {

struct FailedSearch {
  std::span<const Blob> spots;  ///< all that could have been a dot, the largest first; until the next search
  /// Of the guess that came nearest to a landmark: the first thing that speaks against it. kNone: there was no guess
  /// with three dots at least; some two spots lie like a part of a ring in any room.
  Refusal refusal = Refusal::kNone;
  /// Where that guess has the dots; `seen` where an outline is there. Numbered in turn, from any of them.
  std::array<DotObservation, kDotCount> dots{};
  double contrast_lsb = 0;  ///< of ink and paper there
  double noise_lsb = 0;     ///< of the picture, 1-sigma
};

}  // namespace ninedot
