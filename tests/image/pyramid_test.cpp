#include "image/pyramid.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/image/noise_picture.h"

namespace ninedot {
namespace {

TEST(Pyramid, HalvingIsTheRoundedMeanOfFourPixelsForAnyWidthAndStride) {
  for (const int width_px : {2, 3, 17, 33, 64, 101}) {
    const int height_px = 7, stride_bytes = width_px + 5;
    const auto pixels = test::noise_picture(width_px, height_px, stride_bytes, 60);
    const ImageView in{pixels.data(), width_px, height_px, stride_bytes};
    ImageBuffer out(width_px, height_px);
    halve(in, out);
    ASSERT_EQ(out.width_px(), width_px / 2);
    ASSERT_EQ(out.height_px(), 3);
    for (int y = 0; y < out.height_px(); ++y)
      for (int x = 0; x < out.width_px(); ++x) {
        const int sum =
            in.at(2 * x, 2 * y) + in.at(2 * x + 1, 2 * y) + in.at(2 * x, 2 * y + 1) + in.at(2 * x + 1, 2 * y + 1);
        ASSERT_EQ(out.row(y)[x], (sum + 2) / 4) << width_px << ' ' << x << ' ' << y;
      }
  }
}

TEST(Pyramid, EnlargingIsBilinearForAnyWidthAndStride) {
  for (const int width_px : {1, 2, 3, 17, 46}) {
    const int height_px = 5, stride_bytes = width_px + 3;
    const auto pixels = test::noise_picture(width_px, height_px, stride_bytes, 60);
    const ImageView in{pixels.data(), width_px, height_px, stride_bytes};
    ImageBuffer out(2 * width_px, 2 * height_px);
    enlarge(in, out);
    ASSERT_EQ(out.width_px(), 2 * width_px);
    ASSERT_EQ(out.height_px(), 2 * height_px);
    for (int y = 0; y < out.height_px(); ++y)
      for (int x = 0; x < out.width_px(); ++x) {
        // Where the pixel's middle lies in the smaller picture.
        const double u = std::clamp((x + 0.5) / 2 - 0.5, 0.0, width_px - 1.0);
        const double v = std::clamp((y + 0.5) / 2 - 0.5, 0.0, height_px - 1.0);
        const int left = std::min(static_cast<int>(u), std::max(width_px - 2, 0)),
                  top = std::min(static_cast<int>(v), height_px - 2);
        const int right = std::min(left + 1, width_px - 1);
        const double a = u - left, b = v - top;
        const double expected = (1 - b) * ((1 - a) * in.at(left, top) + a * in.at(right, top)) +
                                b * ((1 - a) * in.at(left, top + 1) + a * in.at(right, top + 1));
        ASSERT_NEAR(out.row(y)[x], expected, 0.51) << width_px << ' ' << x << ' ' << y;
      }
  }
}

}  // namespace
}  // namespace ninedot
