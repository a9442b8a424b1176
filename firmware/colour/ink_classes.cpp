// A letter is no one colour: red prints are anything between orange and magenta, and pale or deep. Each letter is a few
// normal distributions around rays from black, long along the ray (how deep the ink is) and narrow across. They are
// drawn up from what inks can be, not fitted to any one camera's pictures.
#include "colour/ink_classes.h"

#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

struct InkRay {
  std::size_t letter;
  float share;             // of the letter's prints
  Eigen::Vector3f middle;  // red, green, blue between black and paper
  float along;             // 1-sigma of its length, relative
  float across;            // 1-sigma of each of red, green and blue besides
};

constexpr std::size_t kColourless = kInkCount;  // in place of a letter
const std::array<InkRay, 13> kRays{{
    {0, 0.7F, {0.00F, 0.00F, 0.00F}, 0, 0.035F},  // P9 is of the same ink
    {0, 0.3F, {0.02F, 0.02F, 0.03F}, 0, 0.09F},   // uneven toner, a lamp's reflection
    {1, 0.5F, {0.50F, 0.04F, 0.04F}, 0.3F, 0.05F},
    {1, 0.25F, {0.60F, 0.20F, 0.04F}, 0.3F, 0.06F},  // towards orange
    {1, 0.25F, {0.50F, 0.03F, 0.18F}, 0.3F, 0.06F},  // towards magenta
    {2, 0.5F, {0.05F, 0.36F, 0.10F}, 0.3F, 0.05F},
    {2, 0.25F, {0.18F, 0.42F, 0.06F}, 0.3F, 0.06F},  // towards yellow
    {2, 0.25F, {0.03F, 0.36F, 0.20F}, 0.3F, 0.06F},  // towards cyan
    {3, 0.5F, {0.04F, 0.10F, 0.42F}, 0.3F, 0.05F},
    {3, 0.25F, {0.10F, 0.05F, 0.30F}, 0.3F, 0.06F},  // towards violet, navy
    {3, 0.25F, {0.03F, 0.25F, 0.50F}, 0.3F, 0.06F},  // towards cyan
    {kColourless, 0.5F, {0.00F, 0.00F, 0.00F}, 0, 0.035F},
    {kColourless, 0.5F, {0.12F, 0.12F, 0.12F}, 0.8F, 0.06F},  // the luma of red, green and blue
}};

// What is none of the inks: a hand, a lamp's reflection, a leaf. Anything between black and twice the paper.
constexpr float kOutlierShare = 0.02F;
// Light that differs on and around the dot by more than this is a shadow's edge, or else something that hides a part of
// both: whole dots in even light stay below 0.07 in rendered rooms, half hidden ones begin at 0.14. Beyond, any of the
// two is as likely.
constexpr float kUnevenLight = 0.12F, kMostOutliers = 0.5F;
constexpr float kOutlierMiddle = 0.5F, kOutlierSigma = 0.6F;
constexpr float kNormal3 = 0.0634936F;  // (2 pi)^(-3/2)

float outlier_share(float shade) noexcept {
  const float s2 = shade * shade / (kUnevenLight * kUnevenLight);
  return kOutlierShare + (kMostOutliers - kOutlierShare) * s2 * s2 / (1 + s2 * s2);
}

/// Density of the normal distribution at `off` from its middle. \param S  symmetric, positive [1]
float normal_density(const Eigen::Vector3f& off, const Eigen::Matrix3f& S) noexcept {
  // The inverse of a symmetric 3 x 3 matrix by its cofactors.
  const float c00 = S(1, 1) * S(2, 2) - S(1, 2) * S(1, 2), c01 = S(0, 2) * S(1, 2) - S(0, 1) * S(2, 2),
              c02 = S(0, 1) * S(1, 2) - S(0, 2) * S(1, 1), c11 = S(0, 0) * S(2, 2) - S(0, 2) * S(0, 2),
              c12 = S(0, 1) * S(0, 2) - S(0, 0) * S(1, 2), c22 = S(0, 0) * S(1, 1) - S(0, 1) * S(0, 1);
  const float determinant = S(0, 0) * c00 + S(0, 1) * c01 + S(0, 2) * c02;
  const float chi2 = (c00 * off.x() * off.x() + c11 * off.y() * off.y() + c22 * off.z() * off.z() +
                      2 * (c01 * off.x() * off.y() + c02 * off.x() * off.z() + c12 * off.y() * off.z())) /
                     determinant;
  return kNormal3 / std::sqrt(determinant) * std::exp(-0.5F * chi2);
}

}  // namespace

InkLikelihoods ink_likelihoods(const MeasuredInk& ink) noexcept {
  std::array<float, kInkCount + 1> densities{};
  for (const InkRay& ray : kRays) {
    const Eigen::Vector3f reflectance =
        ink.black_reflectance * Eigen::Vector3f::Ones() + (1 - ink.black_reflectance) * ray.middle;
    Eigen::Matrix3f S = ink.covariance + (ray.along * ray.middle) * (ray.along * ray.middle).transpose() +
                        (ink.shade * reflectance) * (ink.shade * reflectance).transpose();
    S.diagonal().array() += ray.across * ray.across;
    densities[ray.letter] += ray.share * normal_density(ink.whiteness - ray.middle, S);
  }
  Eigen::Matrix3f anywhere = ink.covariance;
  anywhere.diagonal().array() += kOutlierSigma * kOutlierSigma;
  const float outlier = normal_density(ink.whiteness - kOutlierMiddle * Eigen::Vector3f::Ones(), anywhere);
  const float share = outlier_share(ink.shade);
  for (float& density : densities) density = (1 - share) * density + share * outlier;
  InkLikelihoods likelihoods;
  std::copy_n(densities.begin(), kInkCount, likelihoods.letters.begin());
  likelihoods.colourless = densities[kColourless];
  return likelihoods;
}

}  // namespace ninedot
