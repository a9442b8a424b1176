#include "image/noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/image/noise_picture.h"

namespace ninedot {
namespace {

TEST(Noise, IsEstimatedWithinFivePercentAndEdgesHardlyMoveIt) {
  for (const double sigma_lsb : {1.5, 3.0, 12.0}) {
    auto pixels = test::noise_picture(640, 480, 640, sigma_lsb);
    const ImageView view{pixels.data(), 640, 480, 640};
    EXPECT_NEAR(estimate_noise_lsb(view), sigma_lsb, 0.05 * sigma_lsb + 0.1);
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; x += 64) pixels[static_cast<std::size_t>(y * 640 + x)] = 0;
    EXPECT_NEAR(estimate_noise_lsb(view), sigma_lsb, 0.12 * sigma_lsb + 0.1);
  }
}

TEST(Noise, IsNoneWhereNothingCanBeMeasured) {
  const std::vector<std::uint8_t> pixels(64 * 64, 77);
  EXPECT_EQ(estimate_noise_lsb({pixels.data(), 64, 64, 64}), 0);
  EXPECT_EQ(estimate_noise_lsb({pixels.data(), 2, 64, 64}), 0);
  std::vector<std::uint8_t> stripes(64 * 64);  // the largest second difference of bytes, everywhere
  for (std::size_t i = 0; i < stripes.size(); ++i) stripes[i] = i % 2 == 0 ? 0 : 255;
  EXPECT_NEAR(estimate_noise_lsb({stripes.data(), 64, 64, 64}), 1.4826 * 510 / std::sqrt(6.0), 1);
}

TEST(PictureNoise, GrowsWithBrightnessAsThePictureDoes) {
  std::vector<std::uint8_t> pixels = test::noise_picture(640, 480, 640, 2.0);  // around 128
  const std::vector<std::uint8_t> loud = test::noise_picture(640, 480, 640, 6.0);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const bool is_bright = i % 640 >= 320;
    pixels[i] =
        static_cast<std::uint8_t>(is_bright ? loud[i] / 2 + 144 : pixels[i] / 2 - 16);  // 3 around 208, 1 around 48
  }
  const PictureNoise noise({pixels.data(), 640, 480, 640});
  EXPECT_NEAR(noise.at(48), 1.0, 0.2);
  EXPECT_NEAR(noise.at(208), 3.0, 0.4);
  EXPECT_EQ(noise.at(128), noise.overall_lsb()) << "hardly a pixel is as bright: that of all of them";
  EXPECT_GT(noise.overall_lsb(), noise.at(48));
  EXPECT_LT(noise.overall_lsb(), noise.at(208));
  EXPECT_EQ(noise.at(-10), noise.at(5));
  EXPECT_EQ(noise.at(300), noise.at(250));
  EXPECT_EQ(noise.at(std::nan("")), noise.at(0));
}

}  // namespace
}  // namespace ninedot
