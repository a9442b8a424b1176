#include "detect/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
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

Verification verification_of(const std::vector<std::uint8_t>& pixels, double noise_lsb) {
  Hypothesis hypothesis;
  hypothesis.H_px_plane << -kPixelsPerMetre, 0, 320, 0, -kPixelsPerMetre, 240, 0, 0, 1;
  hypothesis.blob.fill(-1);
  hypothesis.matched = kDotCount;
  const BlobList blobs;
  return verify_landmark({pixels.data(), 640, 480, 640}, hypothesis.H_px_plane, LandmarkGeometry{}, blobs, hypothesis,
                         noise_lsb);
}
bool is_accepted(const std::vector<std::uint8_t>& pixels, double noise_lsb) {
  return verification_of(pixels, noise_lsb).accepted();
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

TEST(Verify, SaysWhatSpeaksAgainstAGuess) {
  const LandmarkGeometry sheet;
  const auto without = [&](std::initializer_list<std::size_t> dots) {
    return sheet_with(200, [&](const Eigen::Vector2d& plane_m) {
      return std::ranges::any_of(
          dots, [&](std::size_t dot) { return (plane_m - sheet.centre_m(dot)).norm() < 1.2 * sheet.radius_m(dot); });
    });
  };
  const auto refusal = [](const std::vector<std::uint8_t>& pixels, double noise_lsb = 1) {
    return verification_of(pixels, noise_lsb).refusal;
  };
  EXPECT_EQ(refusal(sheet_of(120)), Refusal::kNone);
  EXPECT_EQ(refusal(without({0, 1, 2, 3, 4, 5, 8})), Refusal::kFewOutlines);
  EXPECT_EQ(refusal(sheet_of(8), 4), Refusal::kFaint);
  EXPECT_EQ(refusal(without({8})), Refusal::kNoCentre);
  EXPECT_EQ(refusal(without({2})), Refusal::kOtherPattern) << "a hole between two dots, blank as the paper";
  const auto joined =
      sheet_with(80, [](const Eigen::Vector2d& plane_m) { return plane_m.norm() > 0.042 && plane_m.norm() < 0.051; });
  EXPECT_EQ(refusal(joined), Refusal::kDarkBetween);
  const Verification v = verification_of(without({8}), 1);
  EXPECT_NEAR(v.contrast_lsb, 120, 1);
  EXPECT_EQ(v.visible_fraction[kCentreDot], 0);
  EXPECT_EQ(v.visible_fraction[0], 1);
}

}  // namespace
}  // namespace ninedot
