// How far each outline is believed, on made-up fits: eight small dots and a large one, moved off their places.
#include "pose/outline_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ninedot {
namespace {

constexpr double kNoise_lsb2 = 4;
constexpr double kRing_information = 100, kMiddle_information = 2000;  // of a shift by a pixel [LSB^2/px^2]

struct Sheet {
  std::vector<OutlineGroup> groups;
  GroupFits fits;
};

/// Every dot moved along both of the sheet's axes. \param ring_px, middle_px  by how much each of P1..P8, and P9
Sheet sheet_with(double ring_px, double middle_px) {
  Sheet sheet;
  for (std::uint8_t dot = 0; dot < kDotCount; ++dot) {
    sheet.groups.push_back({.count = 40, .dot = dot, .whole_dot = true});
    const bool is_middle = dot == kCentreDot;
    const double information = is_middle ? kMiddle_information : kRing_information;
    const double moved_px = (is_middle ? middle_px : ring_px) * (dot % 2 == 0 ? 1 : -1);
    GroupFit& fit = sheet.fits[dot];
    fit.usable = true;
    fit.degrees_of_freedom = 30;
    fit.squared_residuals = 30 * kNoise_lsb2;
    fit.contrast_lsb = 80;
    fit.paper_lsb = 180;
    fit.shift_information = information;
    fit.normal = information * UnknownMatrix::Identity();
    fit.gradient = UnknownVector::Zero();
    fit.gradient(3) = fit.gradient(5) = information * moved_px;
  }
  return sheet;
}

OutlineWeights weights_of(const Sheet& sheet) {
  OutlineWeights weights;
  weigh_groups(sheet.groups, sheet.fits, 0, weights);
  return weights;
}

/// Of P9's information, in terms of a ring dot's.
double share_of_the_middle(const OutlineWeights& weights) {
  return weights.weight[kCentreDot] * kMiddle_information / (weights.weight[0] * kRing_information);
}

TEST(OutlineWeights, AreAllOfItWhereNothingIsOffItsPlace) {
  const OutlineWeights weights = weights_of(sheet_with(0, 0));
  for (std::size_t dot = 0; dot < kDotCount; ++dot) EXPECT_DOUBLE_EQ(weights.weight[dot], 1) << dot;
  EXPECT_DOUBLE_EQ(weights.noise_variance_lsb2, kNoise_lsb2);
}

TEST(OutlineWeights, OfDotsThatAWarpMovesAllAlikeAreAlike) {
  const OutlineWeights weights = weights_of(sheet_with(0.6, 0.6));
  EXPECT_LT(share_of_the_middle(weights), 2) << "a large dot is no more certain than a small one";
}

TEST(OutlineWeights, OfDotsThatAreMovedAsNoiseMovesThemKeepTheirProportion) {
  const double sixth = std::sqrt(kRing_information / kMiddle_information);
  const OutlineWeights weights = weights_of(sheet_with(0.6, 0.6 * sixth));
  EXPECT_NEAR(share_of_the_middle(weights), kMiddle_information / kRing_information, 1e-6);
  // 9 dots of two places each, moved by three sigmas, six freedoms of the pose and two for what the factor is unsure
  // by.
  EXPECT_NEAR(weights.weight[0], 10 / (18 * 0.36 * kRing_information / kNoise_lsb2), 1e-6);
}

/// By what a shadow's edge may move a dot, it is less certain, and the others are not.
TEST(OutlineWeights, AreLessOfADotThatAnEdgeOfLightMayMove) {
  Sheet sheet = sheet_with(0, 0);
  const double noise_px2 = kNoise_lsb2 / kRing_information;
  sheet.fits[2].light_px2 = 12 * noise_px2;
  sheet.fits[2].gradient(3) = sheet.fits[2].gradient(5) = kRing_information * std::sqrt(12 * noise_px2);
  const OutlineWeights weights = weights_of(sheet);
  EXPECT_NEAR(weights.weight[2], 1.0 / 13, 0.01);
  for (const std::size_t dot : {0U, 1U, 3U, 4U, 5U, 6U, 7U, 8U}) EXPECT_NEAR(weights.weight[dot], 1, 0.01) << dot;
}

double centre_ink_of(const Sheet& sheet) { return centre_ink(sheet.groups, sheet.fits, weights_of(sheet)); }

TEST(CentreInk, IsHowDarkTheMiddleIsBesideTheRing) {
  Sheet sheet = sheet_with(0, 0);
  EXPECT_DOUBLE_EQ(centre_ink_of(sheet), 1);
  sheet.fits[kCentreDot].contrast_lsb = 60;
  EXPECT_DOUBLE_EQ(centre_ink_of(sheet), 0.75);
  sheet.fits[kCentreDot].paper_lsb = 135;
  EXPECT_DOUBLE_EQ(centre_ink_of(sheet), 1) << "in less light";
}

TEST(CentreInk, SaysNothingWhereTheRingIsNotOfOneInkOrNotThere) {
  Sheet sheet = sheet_with(0, 0);
  sheet.fits[kCentreDot].contrast_lsb = 60;
  sheet.fits[2].contrast_lsb = 95;
  EXPECT_DOUBLE_EQ(centre_ink_of(sheet), 1);
  sheet.fits[2].contrast_lsb = 2;
  EXPECT_DOUBLE_EQ(centre_ink_of(sheet), 1);
  sheet.fits[2].contrast_lsb = 80;
  EXPECT_DOUBLE_EQ(centre_ink_of(sheet), 0.75);
}

}  // namespace
}  // namespace ninedot
