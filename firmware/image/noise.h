#pragma once
/// How noisy a picture is.
#include "image/image_view.h"

namespace ninedot {

/// Noise of a picture, from second differences along some rows: 1.4826 median |d2| / sqrt(6). Edges hardly move it.
/// Source: Immerkaer, "Fast Noise Variance Estimation", CVIU 1996, with a median in place of the mean.
/// \return  1-sigma [grey levels]; 0 for a picture narrower than three pixels
/// Memory: none (4 kB of stack). Threads: pure.
double estimate_noise_lsb(const ImageView& in) noexcept;

}  // namespace ninedot
