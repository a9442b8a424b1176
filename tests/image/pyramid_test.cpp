#include "image/pyramid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace ninedot {
namespace {

std::vector<std::uint8_t> noise_picture(int width_px, int height_px, int stride_bytes, double sigma_lsb) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(128, sigma_lsb);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(stride_bytes * height_px), 255);
  for (int y = 0; y < height_px; ++y)
    for (int x = 0; x < width_px; ++x)
      pixels[static_cast<std::size_t>(y * stride_bytes + x)] =
          static_cast<std::uint8_t>(std::clamp(noise(random), 0.0, 255.0));
  return pixels;
}

TEST(Pyramid, HalvingIsTheRoundedMeanOfFourPixelsForAnyWidthAndStride) {
  for (const int width_px : {2, 3, 17, 33, 64, 101}) {
    const int height_px = 7, stride_bytes = width_px + 5;
    const auto pixels = noise_picture(width_px, height_px, stride_bytes, 60);
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

TEST(Pyramid, NoiseIsEstimatedWithinFivePercentAndEdgesHardlyMoveIt) {
  for (const double sigma_lsb : {1.5, 3.0, 12.0}) {
    auto pixels = noise_picture(640, 480, 640, sigma_lsb);
    const ImageView view{pixels.data(), 640, 480, 640};
    EXPECT_NEAR(estimate_noise_lsb(view), sigma_lsb, 0.05 * sigma_lsb + 0.1);
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; x += 64) pixels[static_cast<std::size_t>(y * 640 + x)] = 0;
    EXPECT_NEAR(estimate_noise_lsb(view), sigma_lsb, 0.12 * sigma_lsb + 0.1);
  }
}

}  // namespace
}  // namespace ninedot
