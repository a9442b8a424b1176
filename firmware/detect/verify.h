#pragma once
/// Whether the grey levels agree that a landmark is where a hypothesis says.
#include <array>

#include "base/refusal.h"
#include "detect/hypothesis.h"
#include "image/image_view.h"

namespace ninedot {

/// Of an outline, dark inside and bright outside: the dot is there, whole. 12 of the 16 directions in which it is
/// looked at [1].
inline constexpr float kSeenOutline = 0.75F;

struct Verification {
  Refusal refusal = Refusal::kFewOutlines;          ///< the first thing that speaks against it; kNone: accepted
  double score = 0;                                 ///< to compare hypotheses: dots' worth of outline that is there
  std::array<float, kDotCount> visible_fraction{};  ///< of each outline: dark inside, bright outside
  double contrast_lsb = 0;                          ///< of ink and paper, typical of its outlines
  /// Refused for having three dots of the ring alone: they have no flaw, and nothing else speaks against it. Three dots
  /// are soon found that a landmark's fit: they are something to show, and nothing to act on.
  bool has_three_dots = false;

  bool accepted() const noexcept { return refusal == Refusal::kNone; }
};

/// Looks at both sides of all nine outlines, at the paper between the dots, and at whether what is missing is hidden
/// (something else is there) or absent (blank paper is there: then it is a ring of other dots). Blobs of a dot's size
/// where the sheet must be blank speak against it as well.
/// \param luma  the picture, or a smaller one of less noise
/// \param plane_to_luma  the hypothesis's map from the sheet [m], but into px of `luma`
/// \param noise_lsb  of `luma`
/// Memory: none. Threads: pure.
Verification verify_landmark(const ImageView& luma, const Eigen::Matrix3d& plane_to_luma,
                             const LandmarkGeometry& landmark, const BlobList& blobs, const Hypothesis& hypothesis,
                             double noise_lsb) noexcept;

}  // namespace ninedot
