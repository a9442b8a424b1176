#include "image/pyramid.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace ninedot
