#pragma once
/// Dots that motion smears into each other: the ink of one in the pixels of another.
#include <array>

#include "geometry/landmark.h"
#include "pose/outline_pixels.h"
#include "pose/outline_state.h"

namespace ninedot {

using DotContrasts = std::array<float, kDotCount>;

/// Fills OutlinePixels::ink_of_others_lsb of all groups that are whole dots. The dots are where the state says.
/// Memory: none. Threads: one caller for each OutlinePixels.
/// \param contrasts_lsb  of each dot, by the last fit; 0: unknown \pre the state's blur is a Smear of several parts
void gather_ink_of_others(const LandmarkGeometry& landmark, const OutlineState& state,
                          const DotContrasts& contrasts_lsb, OutlinePixels& pixels) noexcept;

}  // namespace ninedot
