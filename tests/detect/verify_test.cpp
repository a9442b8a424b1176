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

bool is_accepted(const std::vector<std::uint8_t>& pixels, double noise_lsb) {
  Hypothesis hypothesis;
  hypothesis.H_px_plane << -kPixelsPerMetre, 0, 320, 0, -kPixelsPerMetre, 240, 0, 0, 1;
  hypothesis.blob.fill(-1);
  hypothesis.matched = kDotCount;
  const BlobList blobs;
  return verify_landmark({pixels.data(), 640, 480, 640}, hypothesis.H_px_plane, LandmarkGeometry{}, blobs, hypothesis,
                         noise_lsb)
      .accepted;
}
bool is_accepted(int contrast_lsb, double noise_lsb) { return is_accepted(sheet_of(contrast_lsb), noise_lsb); }

/// The sheet with something of this brightness wherever `is_there` says so of a place on it.
template <typename IsThere>
std::vector<std::uint8_t> sheet_with(std::uint8_t brightness_lsb, IsThere is_there) {
  std::vector<std::uint8_t> pixels = sheet_of(120);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      if (is_there(Eigen::Vector2d((320 - x) / kPixelsPerMetre, (240 - y) / kPixelsPerMetre)))
        pixels[static_cast<std::size_t>(y * 640 + x)] = brightness_lsb;
  return pixels;
}

TEST(Verify, WashersAndHolesWithARimAreNoDots) {
  const auto with_holes = [](double share, std::uint8_t brightness_lsb) {
    return sheet_with(brightness_lsb, [share](const Eigen::Vector2d& plane_m) {
      const LandmarkGeometry sheet;
      for (std::size_t dot = 0; dot < kDotCount; ++dot)
        if ((plane_m - sheet.centre_m(dot)).norm() < share * sheet.radius_m(dot)) return true;
      return false;
    });
  };
  EXPECT_TRUE(is_accepted(with_holes(0.4, 80), 1)) << "as dark as the dots: none";
  EXPECT_FALSE(is_accepted(with_holes(0.4, 200), 1));
  EXPECT_FALSE(is_accepted(with_holes(0.4, 140), 1)) << "half as bright as the paper";
}

TEST(Verify, BetweenTheDotsThereIsPaper) {
  const auto with_a_circle = [](std::uint8_t brightness_lsb) {
    return sheet_with(brightness_lsb, [](const Eigen::Vector2d& plane_m) {
      return plane_m.norm() > 0.042 && plane_m.norm() < 0.051;  // half-way from P9 to the ring
    });
  };
  EXPECT_TRUE(is_accepted(with_a_circle(200), 1));
  EXPECT_TRUE(is_accepted(with_a_circle(150), 1)) << "a shadow: brighter than ink by more than a third";
  EXPECT_FALSE(is_accepted(with_a_circle(80), 1));
}

TEST(Verify, FaintOutlinesAreEvidenceOnlyWhereThePictureIsQuieter) {
  EXPECT_TRUE(is_accepted(8, 1));
  EXPECT_FALSE(is_accepted(8, 4));
  EXPECT_TRUE(is_accepted(24, 4));
  EXPECT_FALSE(is_accepted(4, 0.2));
}

}  // namespace
}  // namespace ninedot
