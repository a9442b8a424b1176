#include "image/smooth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "image/pyramid.h"
#include "tests/image/noise_picture.h"

namespace ninedot {
namespace {

TEST(Smooth, IsTheBinomialMeanOfNineForAnyWidthAndStride) {
  for (const int width_px : {1, 2, 3, 17, 33, 64, 101}) {
    const int height_px = 7, stride_bytes = width_px + 5;
    const auto pixels = test::noise_picture(width_px, height_px, stride_bytes, 60);
    const ImageView in{pixels.data(), width_px, height_px, stride_bytes};
    ImageBuffer rows(width_px, height_px), out(width_px, height_px);
    smooth(in, rows, out);
    ASSERT_EQ(out.width_px(), width_px);
    ASSERT_EQ(out.height_px(), height_px);
    const auto at = [&](int x, int y) {
      return in.at(std::clamp(x, 0, width_px - 1), std::clamp(y, 0, height_px - 1));
    };
    for (int y = 0; y < height_px; ++y)
      for (int x = 0; x < width_px; ++x) {
        double sum = 0;
        for (int v = -1; v <= 1; ++v)
          for (int u = -1; u <= 1; ++u) sum += (2 - std::abs(u)) * (2 - std::abs(v)) * at(x + u, y + v);
        ASSERT_NEAR(out.row(y)[x], sum / 16, 1.3) << width_px << ' ' << x << ' ' << y;
      }
  }
}

double variance(const ImageView& picture) {
  double sum = 0, squares = 0;
  for (int y = 0; y < picture.height_px; ++y)
    for (int x = 0; x < picture.width_px; ++x) sum += picture.at(x, y), squares += picture.at(x, y) * picture.at(x, y);
  const double count = picture.width_px * picture.height_px;
  return squares / count - sum * sum / (count * count);
}

TEST(Smooth, LeavesOfNoiseWhatItSaysAndOfTheMeanAll) {
  const int side_px = 200;
  const auto pixels = test::noise_picture(side_px, side_px, side_px, 20);
  const ImageView in{pixels.data(), side_px, side_px, side_px};
  ImageBuffer rows(side_px, side_px), out(side_px, side_px), half(side_px / 2, side_px / 2);
  smooth(in, rows, out);
  halve(out.view(), half);
  EXPECT_NEAR(std::sqrt(variance(out.view()) / variance(in)), kSmoothedNoise, 0.02);
  EXPECT_NEAR(std::sqrt(variance(half.view()) / variance(in)), kHalfSmoothedNoise, 0.02);
  const auto mean = [](const ImageView& picture) {
    double sum = 0;
    for (int y = 0; y < picture.height_px; ++y)
      for (int x = 0; x < picture.width_px; ++x) sum += picture.at(x, y);
    return sum / (picture.width_px * picture.height_px);
  };
  EXPECT_NEAR(mean(out.view()), mean(in), 0.5);
}

}  // namespace
}  // namespace ninedot
