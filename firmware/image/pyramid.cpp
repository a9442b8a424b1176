#include "image/pyramid.h"

#include <opencv2/core/hal/intrin.hpp>

namespace ninedot {

void halve(const ImageView& in, ImageBuffer& out) noexcept {
  const int width = in.width_px / 2;
  const int height = in.height_px / 2;
  out.resize_within(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* a = in.row(2 * y);
    const std::uint8_t* b = in.row(2 * y + 1);
    std::uint8_t* to = out.row(y);
    int x = 0;
    for (; x + 16 <= width; x += 16) {
      cv::v_uint8x16 a_even, a_odd, b_even, b_odd;
      cv::v_load_deinterleave(a + 2 * x, a_even, a_odd);
      cv::v_load_deinterleave(b + 2 * x, b_even, b_odd);
      cv::v_uint16x8 ae0, ae1, ao0, ao1, be0, be1, bo0, bo1;
      cv::v_expand(a_even, ae0, ae1);
      cv::v_expand(a_odd, ao0, ao1);
      cv::v_expand(b_even, be0, be1);
      cv::v_expand(b_odd, bo0, bo1);
      const cv::v_uint16x8 low = cv::v_add_wrap(cv::v_add_wrap(ae0, ao0), cv::v_add_wrap(be0, bo0));
      const cv::v_uint16x8 high = cv::v_add_wrap(cv::v_add_wrap(ae1, ao1), cv::v_add_wrap(be1, bo1));
      cv::v_store(to + x, cv::v_rshr_pack<2>(low, high));
    }
    for (; x < width; ++x)
      to[x] = static_cast<std::uint8_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2) / 4);
  }
}

}  // namespace ninedot
