#include "detect/verify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace ninedot {
namespace {

constexpr double kPixelsPerMetre = 1000;

/// The sheet from in front, without noise, its middle at (320, 240).
std::vector<std::uint8_t> sheet_of(int contrast_lsb) {
  const LandmarkGeometry sheet;
  std::vector<std::uint8_t> pixels(640 * 480, 200);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const Eigen::Vector2d plane_m((320 - x) / kPixelsPerMetre, (240 - y) / kPixelsPerMetre);
      for (std::size_t dot = 0; dot < kDotCount; ++dot)
        if ((plane_m - sheet.centre_m(dot)).norm() < sheet.radius_m(dot))
          pixels[static_cast<std::size_t>(y * 640 + x)] = static_cast<std::uint8_t>(200 - contrast_lsb);
    }
  return pixels;
}

bool is_accepted(int contrast_lsb, double noise_lsb) {
  const auto pixels = sheet_of(contrast_lsb);
  Hypothesis hypothesis;
  hypothesis.H_px_plane << -kPixelsPerMetre, 0, 320, 0, -kPixelsPerMetre, 240, 0, 0, 1;
  hypothesis.blob.fill(-1);
  hypothesis.matched = kDotCount;
  const BlobList blobs;
  return verify_landmark({pixels.data(), 640, 480, 640}, hypothesis.H_px_plane, LandmarkGeometry{}, blobs, hypothesis,
                         noise_lsb)
      .accepted;
}

TEST(Verify, FaintOutlinesAreEvidenceOnlyWhereThePictureIsQuieter) {
  EXPECT_TRUE(is_accepted(8, 1));
  EXPECT_FALSE(is_accepted(8, 4));
  EXPECT_TRUE(is_accepted(24, 4));
  EXPECT_FALSE(is_accepted(4, 0.2));
}

}  // namespace
}  // namespace ninedot
