#pragma once
/// Pictures at half the size, again and again, and at twice the size.
#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// Mean of 2 x 2 pixels, rounded; an odd last column or row is left out.
/// \param out  resized to (width / 2, height / 2) within its own memory
void halve(const ImageView& in, ImageBuffer& out) noexcept;

/// Twice the size, bilinear, so that halve() gives nearly `in` again. Pixel (x, y) of `in` is the middle of (2 x .. 2 x
/// + 1, 2 y .. 2 y + 1) of `out`; beyond the border the border's pixels go on.
/// \param out  resized to (2 width, 2 height) within its own memory
void enlarge(const ImageView& in, ImageBuffer& out) noexcept;

}  // namespace ninedot
