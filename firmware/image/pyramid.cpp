#include "image/pyramid.h"

#include <opencv2/core/hal/intrin.hpp>

namespace ninedot {
namespace {

/// Of eight squares of two by two pixels. Neighbours are added as the halves of words: taking them apart into vectors
/// of even and odd bytes would be twice the work.
cv::v_uint16x8 sums_of_four(const std::uint8_t* above, const std::uint8_t* below) noexcept {
  const auto sums_of_two = [](const std::uint8_t* at) {
    const cv::v_uint16x8 pairs = cv::v_reinterpret_as_u16(cv::v_load(at));
    return cv::v_add_wrap(cv::v_shr<8>(cv::v_shl<8>(pairs)), cv::v_shr<8>(pairs));
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

}  // namespace ninedot
