#include "image/smooth.h"

#include <algorithm>

#include "base/vector_clones.h"

namespace ninedot {
namespace {

/// (a + 2 b + c) / 4 on bytes throughout: an average of two is one or two instructions. One rounds down and one up, so
/// that a picture gets an eighth of a grey level brighter, and not three.
std::uint8_t binomial(std::uint8_t a, std::uint8_t b, std::uint8_t c) noexcept {
  const auto outer = static_cast<std::uint8_t>((a + c) >> 1);
  return static_cast<std::uint8_t>((outer + b + 1) >> 1);
}

}  // namespace

NINEDOT_VECTOR_CLONES
void smooth(const ImageView& in, ImageBuffer& rows, ImageBuffer& out) noexcept {
  const int width = in.width_px, height = in.height_px;
  rows.resize_within(width, height);
  out.resize_within(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* __restrict from = in.row(y);
    std::uint8_t* __restrict to = rows.row(y);
    to[0] = binomial(from[0], from[0], from[std::min(1, width - 1)]);
    for (int x = 1; x + 1 < width; ++x) to[x] = binomial(from[x - 1], from[x], from[x + 1]);
    to[width - 1] = binomial(from[std::max(width - 2, 0)], from[width - 1], from[width - 1]);
  }
  for (int y = 0; y < height; ++y) {
    const std::uint8_t *above = rows.row(std::max(y - 1, 0)), *here = rows.row(y),
                       *below = rows.row(std::min(y + 1, height - 1));
    std::uint8_t* __restrict to = out.row(y);
    for (int x = 0; x < width; ++x) to[x] = binomial(above[x], here[x], below[x]);
  }
}

}  // namespace ninedot
