#include "drivers/picture/jpeg_encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "drivers/picture/picture_file.h"

namespace ninedot {
namespace {

constexpr int kWidth = 61, kHeight = 37;  // odd: blocks and samples end beyond the picture

std::vector<std::uint8_t> ramp() {
  std::vector<std::uint8_t> pixels(kWidth * kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      pixels[static_cast<std::size_t>(y * kWidth + x)] = static_cast<std::uint8_t>(3 * x + y);
  return pixels;
}

TEST(JpegEncoder, GivesTheGreyPictureBack) {
  const auto pixels = ramp();
  JpegEncoder encoder;
  const auto file = encoder.encode({pixels.data(), kWidth, kHeight, kWidth}, {}, 90);
  ASSERT_TRUE(file.has_value());
  std::vector<std::uint8_t> back(pixels.size());
  ASSERT_TRUE(PictureDecoder({kWidth, kHeight}).decode(*file, back));
  for (std::size_t i = 0; i < pixels.size(); ++i) ASSERT_NEAR(back[i], pixels[i], 6) << i;
}

TEST(JpegEncoder, GivesTheColourBackWhereverTheCameraHadIt) {
  const auto pixels = ramp();
  // Blue on the left, red on the right: pairs at half the width, and between the luma.
  constexpr int kSamples = (kWidth + 1) / 2;
  std::vector<std::uint8_t> bytes(4 * kSamples * kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kSamples; ++x) {
      const auto at = static_cast<std::size_t>(4 * (y * kSamples + x));
      bytes[at + 1] = x < kSamples / 2 ? 180 : 100;
      bytes[at + 3] = x < kSamples / 2 ? 90 : 200;
    }
  const ChromaView chroma{bytes.data() + 1, bytes.data() + 3, kSamples, kHeight, 4, 4 * kSamples};
  JpegEncoder encoder;
  const auto file = encoder.encode({pixels.data(), kWidth, kHeight, kWidth}, chroma, 95);
  ASSERT_TRUE(file.has_value());
  std::vector<std::uint8_t> luma(pixels.size()), samples(2 * pixels.size());
  const auto back = PictureDecoder({kWidth, kHeight}).decode_with_chroma(*file, luma, samples);
  ASSERT_TRUE(back.has_value());
  for (const int x : {2, back->width - 3}) {
    const bool left = x < back->width / 2;
    EXPECT_NEAR(back->cb_at(x, back->height / 2), left ? 180 : 100, 8);
    EXPECT_NEAR(back->cr_at(x, back->height / 2), left ? 90 : 200, 8);
  }
}

}  // namespace
}  // namespace ninedot
