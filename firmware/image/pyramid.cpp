#include "image/pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core/hal/intrin.hpp>

#include "base/contract.h"

namespace ninedot {

ImageBuffer::ImageBuffer(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {
  EXPECTS(width_px > 0 && height_px > 0);
  stride_ = (width_px + 2 * kPadding_px + 63) / 64 * 64;
  bytes_.assign(static_cast<std::size_t>(stride_ * (height_px + 1) + 64), 0);
  const auto misalignment = reinterpret_cast<std::uintptr_t>(bytes_.data()) % 64;
  first_ = bytes_.data() + (misalignment == 0 ? 0 : 64 - misalignment);
}

void ImageBuffer::resize_within(int width_px, int height_px) noexcept {
  EXPECTS(width_px + kPadding_px <= stride_ &&
          stride_ * (height_px + 1) + 64 <= static_cast<std::ptrdiff_t>(bytes_.size()));
  width_px_ = width_px;
  height_px_ = height_px;
}

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

double estimate_noise_lsb(const ImageView& in) noexcept {
  constexpr int kRowStep = 8;
  constexpr int kColumnStep = 2;
  std::array<std::uint32_t, 1024> histogram{};
  std::uint32_t count = 0;
  for (int y = kRowStep / 2; y < in.height_px; y += kRowStep) {
    const std::uint8_t* row = in.row(y);
    for (int x = 1; x + 1 < in.width_px; x += kColumnStep) {
      ++histogram[static_cast<std::size_t>(std::abs(row[x - 1] - 2 * row[x] + row[x + 1]))];
      ++count;
    }
  }
  // Second differences are whole numbers: a plain median of them would step by 0.6 grey levels, so interpolate in its
  // bin.
  double below = 0;
  for (std::size_t value = 0; value < histogram.size(); ++value) {
    const double here = histogram[value];
    if (below + here >= 0.5 * count) {
      const double median = static_cast<double>(value) - 0.5 + (here > 0 ? (0.5 * count - below) / here : 0.5);
      return 1.4826 * std::max(median, 0.0) / std::sqrt(6.0);
    }
    below += here;
  }
  return 0;
}

}  // namespace ninedot
