#include "image/pyramid.h"

#include <algorithm>
#include <opencv2/core/hal/intrin.hpp>

#include "image/vector_operators.h"

namespace ninedot {
namespace {

/// Of eight squares of two by two pixels. Neighbours are added as the halves of words: taking them apart into vectors
/// of even and odd bytes would be twice the work.
cv::v_uint16x8 sums_of_four(const std::uint8_t* above, const std::uint8_t* below) noexcept {
  const cv::v_uint16x8 even_bytes = cv::v_setall_u16(0xFF);
  const auto sums_of_two = [&](const std::uint8_t* at) {
    const cv::v_uint16x8 pairs = cv::v_reinterpret_as_u16(cv::v_load(at));
    return cv::v_add_wrap(common_bits(pairs, even_bytes), cv::v_shr<8>(pairs));
  };
  return cv::v_add_wrap(sums_of_two(above), sums_of_two(below));
}

}  // namespace

void halve(const ImageView& in, ImageBuffer& out) noexcept {
  const int width = in.width_px / 2;
  const int height = in.height_px / 2;
  out.resize_within(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* a = in.row(2 * y);
    const std::uint8_t* b = in.row(2 * y + 1);
    std::uint8_t* to = out.row(y);
    int x = 0;
    for (; x + 16 <= width; x += 16)
      cv::v_store(to + x,
                  cv::v_rshr_pack<2>(sums_of_four(a + 2 * x, b + 2 * x), sums_of_four(a + 2 * x + 16, b + 2 * x + 16)));
    for (; x < width; ++x)
      to[x] = static_cast<std::uint8_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2) / 4);
  }
}

void enlarge(const ImageView& in, ImageBuffer& out) noexcept {
  out.resize_within(2 * in.width_px, 2 * in.height_px);
  for (int y = 0; y < out.height_px(); ++y) {
    // A quarter of a pixel from the middle of the nearer one: it counts three times as much as the other.
    const std::uint8_t* near = in.row(y / 2);
    const std::uint8_t* far = in.row(std::clamp(y / 2 + (y % 2 == 0 ? -1 : 1), 0, in.height_px - 1));
    std::uint8_t* to = out.row(y);
    for (int x = 0; x < out.width_px(); ++x) {
      const int here = x / 2;
      const int beside = std::clamp(here + (x % 2 == 0 ? -1 : 1), 0, in.width_px - 1);
      to[x] = static_cast<std::uint8_t>((9 * near[here] + 3 * (near[beside] + far[here]) + far[beside] + 8) / 16);
    }
  }
}

}  // namespace ninedot
