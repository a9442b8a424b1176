#pragma once
/// How likely a measured ink is of each letter.
#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace ninedot {

/// The letters of landmark_codes.h, in this order.
inline constexpr std::size_t kInkCount = 4;
inline constexpr std::array<char, kInkCount> kInkLetters{'K', 'R', 'G', 'B'};

/// An ink's red, green and blue between the sheet's black, 0, and its paper, 1, as light: whatever the light's colour,
/// a veil of haze or a faded print make of a picture, they make of all three alike.
struct MeasuredInk {
  Eigen::Vector3f whiteness{0, 0, 0};                    ///< [1]
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();  ///< of it [1]
  /// 1-sigma of the light on the dot against that on the paper around it, as a logarithm [1]: an ink brightens or
  /// darkens by that share of its reflectance.
  float shade = 0;
  float black_reflectance = 0;  ///< of the sheet's black, relative to its paper, 0..1
};

/// Probability densities of a measured ink.
struct InkLikelihoods {
  std::array<float, kInkCount> letters{};  ///< for each of kInkLetters, a share for what is none of these included [1]
  float colourless = 0;  ///< for any ink in a picture that has lost its colour, from black to grey [1]
};

/// Memory: none. Threads: pure.
InkLikelihoods ink_likelihoods(const MeasuredInk& ink) noexcept;

}  // namespace ninedot
