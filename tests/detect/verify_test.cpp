#include "detect/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
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

Verification verification_of(const std::vector<std::uint8_t>& pixels, double noise_lsb, const BlobList& blobs = {}) {
  Hypothesis hypothesis;
  hypothesis.H_px_plane << -kPixelsPerMetre, 0, 320, 0, -kPixelsPerMetre, 240, 0, 0, 1;
  hypothesis.blob.fill(-1);
  hypothesis.matched = kDotCount;
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

std::vector<std::uint8_t> sheet_without(std::initializer_list<std::size_t> dots) {
  const LandmarkGeometry sheet;
  return sheet_with(200, [&](const Eigen::Vector2d& plane_m) {
    return std::ranges::any_of(
        dots, [&](std::size_t dot) { return (plane_m - sheet.centre_m(dot)).norm() < 1.2 * sheet.radius_m(dot); });
  });
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
  const auto refusal = [](const std::vector<std::uint8_t>& pixels, double noise_lsb = 1) {
    return verification_of(pixels, noise_lsb).refusal;
  };
  EXPECT_EQ(refusal(sheet_of(120)), Refusal::kNone);
  EXPECT_EQ(refusal(sheet_without({0, 1, 2, 3, 4, 5, 8})), Refusal::kFewOutlines);
  EXPECT_EQ(refusal(sheet_of(8), 4), Refusal::kFaint);
  EXPECT_EQ(refusal(sheet_without({8})), Refusal::kNoCentre);
  EXPECT_EQ(refusal(sheet_without({2})), Refusal::kOtherPattern) << "a hole between two dots, blank as the paper";
  const auto joined =
      sheet_with(80, [](const Eigen::Vector2d& plane_m) { return plane_m.norm() > 0.042 && plane_m.norm() < 0.051; });
  EXPECT_EQ(refusal(joined), Refusal::kDarkBetween);
  const Verification v = verification_of(sheet_without({8}), 1);
  EXPECT_NEAR(v.contrast_lsb, 120, 1);
  EXPECT_EQ(v.visible_fraction[kCentreDot], 0);
  EXPECT_EQ(v.visible_fraction[0], 1);
}

/// A disc of ink on the sheet, and the blob that it leaves.
void paint_disc(std::vector<std::uint8_t>& pixels, BlobList& blobs, const Eigen::Vector2d& at_m, double radius_m) {
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      if ((Eigen::Vector2d((320 - x) / kPixelsPerMetre, (240 - y) / kPixelsPerMetre) - at_m).norm() < radius_m)
        pixels[static_cast<std::size_t>(y * 640 + x)] = 80;
  Blob blob{};
  blob.x_px = static_cast<float>(320 - at_m.x() * kPixelsPerMetre);
  blob.y_px = static_cast<float>(240 - at_m.y() * kPixelsPerMetre);
  blob.area_px2 = static_cast<float>(std::numbers::pi * std::pow(radius_m * kPixelsPerMetre, 2));
  (void)blobs.try_push_back(blob);
}

TEST(Verify, AWholeDotBesideItsPlaceIsAnotherPattern) {
  const LandmarkGeometry sheet;
  // Moved by less than its radius: a part of the outline where it should be is still ink beside paper.
  const auto refusal = [&](double blob_share) {
    std::vector<std::uint8_t> pixels = sheet_without({2});
    BlobList blobs;
    paint_disc(pixels, blobs, sheet.centre_m(2) + Eigen::Vector2d(0, 0.52 * sheet.dot_radius_m), sheet.dot_radius_m);
    blobs[0].area_px2 *= static_cast<float>(blob_share);
    return verification_of(pixels, 1, blobs).refusal;
  };
  EXPECT_EQ(refusal(1), Refusal::kOtherPattern);
  EXPECT_EQ(refusal(0.7), Refusal::kNone) << "what something else has left of a dot";
  EXPECT_EQ(refusal(1.5), Refusal::kNone) << "something else with a part of it";
}

TEST(Verify, DotsOfOtherSizesAreAnotherPatternWhereThereAreThree) {
  const LandmarkGeometry sheet;
  const auto refusal = [&](std::initializer_list<std::size_t> dots, double share) {
    std::vector<std::uint8_t> pixels = sheet_without(dots);
    BlobList blobs;
    for (const std::size_t dot : dots) paint_disc(pixels, blobs, sheet.centre_m(dot), share * sheet.dot_radius_m);
    return verification_of(pixels, 1, blobs).refusal;
  };
  // Less and more than what counts as a stranger: nothing but their size in these places speaks against them.
  EXPECT_EQ(refusal({2, 3, 4}, 0.6), Refusal::kOtherPattern);
  EXPECT_EQ(refusal({2, 3, 4}, 1.6), Refusal::kOtherPattern);
  EXPECT_EQ(refusal({2, 3}, 0.6), Refusal::kNone) << "an edge cuts two";
  EXPECT_EQ(refusal({2, 3}, 1.6), Refusal::kNone);
  EXPECT_EQ(refusal({2, 3, 4}, 0.2), Refusal::kNone) << "specks on what hides them";
}

}  // namespace
}  // namespace ninedot
