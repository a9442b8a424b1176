#include <gtest/gtest.h>

#include "pose/pose_of_outlines.h"
#include "tests/image/noise_picture.h"

namespace ninedot {
namespace {

/// A fit of P9 and its neighbours from P1 on, without a fault but the residual that it leaves of a contrast of 100.
PoseCandidate candidate_with(int dots, double residual_lsb) {
  PoseCandidate candidate;
  candidate.pose.dots_used = dots;
  candidate.outlines.T_camera_landmark.translation_m = {0, 1, 0};  // seen from in front
  candidate.dot_radius_px = 6;
  candidate.outlines.blur_px2 = 0.5;
  candidate.visible_share[kCentreDot] = 1;
  for (int dot = 0; dot + 1 < dots; ++dot) candidate.visible_share[static_cast<std::size_t>(dot)] = 1;
  candidate.fit = {100, 178, residual_lsb};
  return candidate;
}

PictureNoise noise_of(double sigma_lsb) {
  const auto pixels = test::noise_picture(640, 480, 640, sigma_lsb);
  return PictureNoise({pixels.data(), 640, 480, 640});
}

TEST(FitsPicture, WhatIsLeftOverIsHeldAgainstTheNoiseOfThePictureAndNotAgainstItself) {
  const PictureNoise quiet = noise_of(2), noisy = noise_of(6);
  EXPECT_TRUE(fits_picture(candidate_with(6, 2), quiet, {}));
  EXPECT_FALSE(fits_picture(candidate_with(6, 8), quiet, {}));
  EXPECT_TRUE(fits_picture(candidate_with(6, 8), noisy, {}));
  EXPECT_FALSE(fits_picture(candidate_with(6, 16), noisy, {}));
}

TEST(FitsPicture, NineDotsMayLeaveMoreThanSixBecauseTheyAreNoChance) {
  const PictureNoise quiet = noise_of(2);
  EXPECT_TRUE(fits_picture(candidate_with(9, 8), quiet, {}));
  EXPECT_FALSE(fits_picture(candidate_with(9, 16), quiet, {}));
}

TEST(FitsPicture, FiveGreyLevelsOfContrastAreTextureInAUsualPicture) {
  const PictureNoise usual = noise_of(2);
  PoseCandidate candidate = candidate_with(9, 2);
  EXPECT_TRUE(fits_picture(candidate, usual, {}));
  candidate.fit.contrast_lsb = 5;
  EXPECT_FALSE(fits_picture(candidate, usual, {}));
}

TEST(FitsPicture, NothingThatACameraDoesMovesOutlinesOutwards) {
  const PictureNoise usual = noise_of(2);
  PoseCandidate candidate = candidate_with(9, 2);
  candidate.outlines.offset_px = -0.8;
  EXPECT_TRUE(fits_picture(candidate, usual, {})) << "clipped, or sharpened";
  candidate.outlines.offset_px = 0.8;
  EXPECT_FALSE(fits_picture(candidate, usual, {}));
  candidate.outlines.offset_px = 0.3;
  EXPECT_TRUE(fits_picture(candidate, usual, {})) << "ink that ran";
  candidate.dot_radius_px = 30, candidate.outlines.offset_px = 1.2;
  EXPECT_FALSE(fits_picture(candidate, usual, {})) << "little of large dots";
}

TEST(FitsPicture, DotsOfAFewPixelsAreNoLargerThanPrinted) {
  const PictureNoise usual = noise_of(2);
  const auto fits = [&](double radius_px, double sigma_px) {
    PoseCandidate candidate = candidate_with(9, 2);
    candidate.dot_radius_px = radius_px;
    candidate.outlines.offset_px = 0.2;
    candidate.offset_sigma_px = sigma_px;
    return fits_picture(candidate, usual, {});
  };
  EXPECT_TRUE(fits(6, 0.01));
  EXPECT_FALSE(fits(2, 0.01)) << "by a tenth";
  EXPECT_TRUE(fits(2, 0.05)) << "noise";
}

TEST(FitsPicture, OutlinesBesideAHiddenDotLieWhereTheyShould) {
  const PictureNoise usual = noise_of(2);
  PoseCandidate candidate = candidate_with(9, 2);
  candidate.pose.rms_px = 0.25;
  EXPECT_TRUE(fits_picture(candidate, usual, {})) << "a bumpy sheet";
  candidate = candidate_with(8, 2);
  candidate.pose.rms_px = 0.25;
  EXPECT_FALSE(fits_picture(candidate, usual, {}));
  candidate.pose.rms_px = 0.1;
  EXPECT_TRUE(fits_picture(candidate, usual, {}));
}

TEST(FitsPicture, WhatIsOffInEveryWayALittleIsAnotherThing) {
  const PictureNoise usual = noise_of(2);
  const auto fits = [&](double size, double second, double fourth) {
    PoseCandidate candidate = candidate_with(9, 2);
    candidate.shape.size = size, candidate.shape.second = second, candidate.shape.fourth = fourth;
    return fits_picture(candidate, usual, {});
  };
  EXPECT_TRUE(fits(0.04, 0, 0));
  EXPECT_TRUE(fits(0, 0.1, 0));
  EXPECT_TRUE(fits(0, 0, 0.03));
  EXPECT_FALSE(fits(0.04, 0.1, 0.03));
}

TEST(FitsPicture, AMiddleThatIsPalerThanTheRingIsSmaller) {
  const PictureNoise usual = noise_of(2);
  PoseCandidate candidate = candidate_with(9, 2);
  candidate.shape.centre_ink = 0.9;
  EXPECT_TRUE(fits_picture(candidate, usual, {}));
  candidate.shape.centre_ink = 0.8;
  EXPECT_FALSE(fits_picture(candidate, usual, {}));
  EXPECT_FALSE(fits_picture(candidate, usual, {.is_coloured = true})) << "P9 is black, whatever the ring's colours";
  candidate.visible_share[2] = 0.8;
  EXPECT_FALSE(fits_picture(candidate, usual, {})) << "beside a ring that is partly covered";
}

TEST(FitsPicture, WhatHidesTheCentreHidesADotOfTheRingAsMuch) {
  const PictureNoise usual = noise_of(2);
  const auto fits = [&](double least_of_ring, double centre) {
    PoseCandidate candidate = candidate_with(9, 2);
    candidate.visible_share[1] = candidate.visible_share[5] = least_of_ring;
    candidate.visible_share[kCentreDot] = centre;
    return fits_picture(candidate, usual, {});
  };
  EXPECT_TRUE(fits(1, 0.8)) << "a fly on it";
  EXPECT_FALSE(fits(1, 0.5));
  EXPECT_FALSE(fits(0.75, 0.5)) << "a hub of another size";
  EXPECT_TRUE(fits(0.4, 0.5)) << "a cable across";
}

TEST(FitsPicture, NoInkIsDarkerThanBlack) {
  const PictureNoise usual = noise_of(2);
  PoseCandidate candidate = candidate_with(9, 2);
  candidate.fit = {170, 178, 2};
  EXPECT_TRUE(fits_picture(candidate, usual, {}));
  candidate.fit = {190, 178, 2};
  EXPECT_FALSE(fits_picture(candidate, usual, {}));
}

TEST(FitsPicture, OutlinesLieOffByWhatBlurThatIsNoGaussianLeaves) {
  const PictureNoise usual = noise_of(2);
  PoseCandidate candidate = candidate_with(9, 2);
  candidate.pose.rms_px = 0.5;
  EXPECT_FALSE(fits_picture(candidate, usual, {}));
  candidate.outlines.blur_px2 = 12;
  EXPECT_TRUE(fits_picture(candidate, usual, {})) << "out of focus";
  candidate.outlines.blur_px2 = 8;
  EXPECT_FALSE(fits_picture(candidate, usual, {}));
  candidate.outlines.blur_cos_px2 = 4;
  EXPECT_TRUE(fits_picture(candidate, usual, {})) << "moved";
}

TEST(FitsPicture, DotsWhoseShapeNobodyCanTellAreHeldAgainstStricterLimits) {
  const PictureNoise quiet = noise_of(2);
  const auto fits = [&](PoseCandidate candidate, bool is_unknown) {
    candidate.shape.is_unknown = is_unknown;
    return fits_picture(candidate, quiet, {});
  };
  EXPECT_TRUE(fits(candidate_with(9, 2), true));
  EXPECT_TRUE(fits(candidate_with(6, 2), false));
  EXPECT_FALSE(fits(candidate_with(6, 2), true)) << "six spots in their places may be chance";
  EXPECT_TRUE(fits(candidate_with(9, 8), false));
  EXPECT_FALSE(fits(candidate_with(9, 8), true)) << "more than noise";
  PoseCandidate off = candidate_with(9, 2);
  off.pose.rms_px = 0.25;
  EXPECT_TRUE(fits(off, false));
  EXPECT_FALSE(fits(off, true)) << "a sheet that is not flat";
}

}  // namespace
}  // namespace ninedot
