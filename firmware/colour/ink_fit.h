#pragma once
/// What a disc is printed with, by the samples at and around it.
#include <Eigen/Core>

#include "colour/ink_samples.h"

namespace ninedot {

/// Light of paper that is darker than (13 / 255)^2 has a colour that is noise. [1]
inline constexpr float kLeastPaper = 0.0025F;

/// Least squares of light = paper + cover (ink - paper), for red, green and blue.
struct InkFit {
  bool usable = false;             ///< enough samples, of ink and of paper
  Eigen::Vector3f paper{0, 0, 0};  ///< light of the paper around it [1]
  Eigen::Vector3f drop{0, 0, 0};   ///< (paper - ink) / paper, of each colour: 0 paper, nearly 1 black ink [1]
  /// Of `paper` and `drop`, for samples of variance 1 relative to the paper [1].
  float paper_variance = 0, drop_variance = 0;
  float freedoms = 0;  ///< samples less the two that are fitted [1]
  /// Sum of squares and products of what the samples differ from the fit, relative to the paper [1].
  Eigen::Matrix3f residuals = Eigen::Matrix3f::Zero();
};

/// What the rest of the sheet says of the paper around a disc.
struct PaperPrior {
  Eigen::Vector3f light{0, 0, 0};  ///< as InkFit::paper [1]
  float samples = 0;               ///< how many samples of the disc's own it is worth; 0: nothing [1]
};

/// Memory: none. Threads: pure.
InkFit fit_ink(const InkSums& sums, const PaperPrior& prior = {}) noexcept;

}  // namespace ninedot
