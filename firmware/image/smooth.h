#pragma once
/// A picture's noise, taken out with little of its detail.
#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// What is left of a picture's white noise by smooth(), sqrt(6) / 4 for each direction, and of what is smoothed and
/// then halved: (1 3 3 1) / 8, which has sqrt(20) / 8 of it [1].
inline constexpr double kSmoothedNoise = 6.0 / 16, kHalfSmoothedNoise = 20.0 / 64;

/// Each pixel's mean with its neighbours, (1 2 1) / 4 along rows and columns, rounded; beyond the border the border's
/// pixels go on. An edge is as if it were blurred by 0.7 px more.
/// \param rows  for its work \param out  resized, as rows, to the size of `in` within its own memory
void smooth(const ImageView& in, ImageBuffer& rows, ImageBuffer& out) noexcept;

}  // namespace ninedot
