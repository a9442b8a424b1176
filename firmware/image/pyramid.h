#pragma once
/// Pictures at half the size, again and again.
#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// Mean of 2 x 2 pixels, rounded; an odd last column or row is left out.
/// \param out  resized to (width / 2, height / 2) within its own memory
void halve(const ImageView& in, ImageBuffer& out) noexcept;

}  // namespace ninedot
