#pragma once
/// How far each group of pixels is to be believed.
///
/// Groups whose outline is not where the others say, or that show no outline at all (hidden, cut by a shadow), lose
/// their weight (iteratively reweighted least squares; Geman & McClure, "Statistical methods for tomographic image
/// reconstruction", Bull. ISI 52, 1987).
#include <array>
#include <span>

#include "pose/estimate.h"
#include "pose/outline_sums.h"

namespace ninedot {

using GroupFits = std::array<GroupFit, kMaxGroups>;

struct OutlineWeights {
  std::array<double, kMaxGroups> weight{};       ///< of each group in the normal equations, 0..1
  std::array<bool, kMaxGroups> outline_there{};  ///< an outline where it belongs, though its light may be spoiled
  double noise_variance_lsb2 = 1;                ///< of one pixel [LSB^2]
  double rms_px = 0;  ///< groups' shifts against the state: root mean square, each by its certainty
  OutlineFit fit;     ///< `residual_lsb` is the root of noise_variance_lsb2
};

/// Weights of all groups from their contrast, their residuals and their shift against what the state says.
/// \param shift_floor_px  what the state may still be off by: while it is, every group is shifted, and none an outlier
/// Memory: none. Threads: pure.
void weigh_groups(std::span<const OutlineGroup> groups, const GroupFits& fits, double shift_floor_px,
                  OutlineWeights& weights) noexcept;

/// By how much ink's grey level changes where the light does, when paper's changes by 1 (OutlinePixels::ink_share).
/// Memory: none. Threads: pure.
float ink_share_of(const OutlineFit& fit) noexcept;

/// How an sRGB curve bends the grey levels of dots whose outlines are there: by their own light. Others stay.
/// \param bends  of each dot [1]
/// Memory: none. Threads: pure.
void bend_tones(std::span<const OutlineGroup> groups, const GroupFits& fits, const OutlineWeights& weights,
                std::array<ToneBend, kDotCount>& bends) noexcept;

/// How dark P9 is beside its paper, in shares of the ring's dots. A dot whose outline is all blur looks paler where it
/// is smaller than its model, and darker where it is larger.
/// \return  [1]; 1 where the ring's dots differ (shadows, colours), or one of the nine has no outline
/// Memory: none. Threads: pure.
double centre_ink(std::span<const OutlineGroup> groups, const GroupFits& fits, const OutlineWeights& weights) noexcept;

/// Whether pixels lie so far about a group's light that a shadow's edge, or another one, may cross it.
/// \param variance_lsb2  theirs [LSB^2] \param noise_variance_lsb2  of one pixel [LSB^2]
/// Memory: none. Threads: pure.
bool is_shadowed(double variance_lsb2, double contrast_lsb, double noise_variance_lsb2) noexcept;

}  // namespace ninedot
