#include "pose/outline_weights.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

// A group shows an outline if its contrast is at least this share of the median group's, scaled by its own light: what
// hides a dot is dark or bright on both sides. Half of what ink keeps behind a veil of haze that halves the contrast.
constexpr double kLeastContrastShare = 0.3;
constexpr double kLeastContrast_lsb = 4;  // two grey levels of noise, twice: below, an edge's place is noise
// Light from one group to another that is taken for light and not for another surface.
constexpr double kDarkestLight = 0.25, kBrightestLight = 1.5;
// The noise is this quantile of the groups' variances. Not the median: half of the groups may be spoiled by shadows.
constexpr double kNoiseQuantile = 0.35;
constexpr double kRoundingVariance_lsb2 = 1.0 / 12;  // what rounding to whole grey levels leaves of a noiseless picture
// What the outline's model itself leaves over of the contrast (a Gaussian for a lens's point spread; rendered sRGB
// pictures without noise leave 1 to 2 %).
constexpr double kModelMisfit = 0.02;
constexpr double kNoiseSlack = 3;   // times the noise's variance: chi^2 of 8 degrees of freedom exceeds that in 0.2 %
constexpr double kShiftSigmas = 3;  // Geman & McClure's scale: half of the weight is left at 1.9 sigmas, a quarter at 3
constexpr double kThereTrust = 0.25;  // of a group that counts as seen: the weight at that scale
constexpr double kSpoiledLight = 64;  // a misfit of eight times the allowed variance, squared: light, not another thing
// Smooth light leaves 0.7 to 1.6 of the noise's variance over a whole dot; beyond this a shadow's edge crosses it.
constexpr double kShadowVariance = 2.5;
constexpr double kOutlierChi2 = 16;  // times the median group's: four times as far out

double square(double x) noexcept { return x * x; }

/// The value that `share` of the values lie below; reorders them.
double quantile(std::span<double> values, double share) noexcept {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double variance_of(const GroupFit& fit) noexcept { return fit.squared_residuals / fit.degrees_of_freedom; }

/// What the groups have in common.
struct Typical {
  double contrast_lsb, paper_lsb, noise_variance_lsb2;
};

Typical typical_of(std::span<const OutlineGroup> groups, const GroupFits& fits) noexcept {
  std::array<double, kMaxGroups> contrasts, papers, variances;
  std::size_t count = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    if (!fit.usable || fit.contrast_lsb < kLeastContrast_lsb) continue;
    contrasts[count] = fit.contrast_lsb;
    papers[count] = fit.paper_lsb;
    variances[count] = variance_of(fit);
    ++count;
  }
  return {quantile(std::span(contrasts).first(count), 0.5), quantile(std::span(papers).first(count), 0.5),
          std::max(quantile(std::span(variances).first(count), kNoiseQuantile), kRoundingVariance_lsb2)};
}

/// Variance of the groups' places about the model's beyond what noise explains: warped sheets, shadows, the model's own
/// faults. DerSimonian & Laird, "Meta-analysis in clinical trials", Controlled Clinical Trials 7 (1986): the excess of
/// the weighted squares over their expectation. A group is moved along and across and grown (whole dots), or shifted.
double model_variance_px2(std::span<const OutlineGroup> groups, const GroupFits& fits,
                          const Typical& typical) noexcept {
  struct Displaced {
    double chi2, information;
    int freedom;
  };
  InlineVector<Displaced, kMaxGroups> displaced;
  std::array<double, kMaxGroups> per_freedom;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    if (!fit.usable || fit.contrast_lsb < kLeastContrastShare * typical.contrast_lsb) continue;
    Displaced d{fit.shift_px * fit.shift_px * fit.shift_information / typical.noise_variance_lsb2,
                fit.shift_information / typical.noise_variance_lsb2, 1};
    if (groups[i].whole_dot) {
      constexpr std::array<Eigen::Index, 3> kMoves{3, 5, 6};  // translation along the sheet's axes, growth
      const Eigen::Matrix3d N = fit.normal(kMoves, kMoves);
      const Eigen::Vector3d g = fit.gradient(kMoves);
      d = {g.dot(N.ldlt().solve(g)) / typical.noise_variance_lsb2, d.information, 3};
    }
    per_freedom[displaced.size()] = d.chi2 / d.freedom;
    (void)displaced.try_push_back(d);  // no more of them than groups
  }
  const double most = kOutlierChi2 * std::max(quantile(std::span(per_freedom).first(displaced.size()), 0.5), 1.0);
  double excess = kUnknowns, information = 0;
  for (const Displaced& d : displaced) {
    if (!(d.chi2 < most * d.freedom)) continue;
    excess += d.chi2 - d.freedom;
    information += d.freedom * d.information;
  }
  return information > 0 ? std::max(excess, 0.0) / information : 0;
}

bool shows_an_outline(const GroupFit& fit, const Typical& typical) noexcept {
  if (!fit.usable) return false;
  const double light = std::clamp(fit.paper_lsb / std::max(typical.paper_lsb, 1.0), kDarkestLight, kBrightestLight);
  return fit.contrast_lsb >= std::max(kLeastContrast_lsb, kLeastContrastShare * typical.contrast_lsb * light);
}

}  // namespace

void weigh_groups(std::span<const OutlineGroup> groups, const GroupFits& fits, double shift_floor_px,
                  OutlineWeights& weights) noexcept {
  const Typical typical = typical_of(groups, fits);
  weights.noise_variance_lsb2 = typical.noise_variance_lsb2;
  weights.fit = {typical.contrast_lsb, typical.paper_lsb, std::sqrt(typical.noise_variance_lsb2)};
  const double model_px2 = model_variance_px2(groups, fits, typical);
  double sum_weight = 0, sum_shift = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    weights.weight[i] = 0;
    weights.outline_there[i] = false;
    if (!shows_an_outline(fit, typical)) continue;
    const double allowed_lsb2 = kNoiseSlack * typical.noise_variance_lsb2 + square(kModelMisfit * fit.contrast_lsb);
    const double expected_px2 = typical.noise_variance_lsb2 / fit.shift_information;
    const double u2 = fit.shift_px * fit.shift_px /
                      (square(kShiftSigmas) * (expected_px2 + model_px2 + shift_floor_px * shift_floor_px));
    double trust = 1 / ((1 + u2) * (1 + u2));
    const double misfit = std::max(variance_of(fit) / allowed_lsb2, 1.0);
    weights.outline_there[i] = trust / std::max(misfit * misfit / kSpoiledLight, 1.0) > kThereTrust;
    trust /= misfit * misfit;
    sum_weight += trust;
    sum_shift += trust * fit.shift_px * fit.shift_px;
    weights.weight[i] = trust / (1 + model_px2 / expected_px2);
  }
  weights.rms_px = sum_weight > 0 ? std::sqrt(sum_shift / sum_weight) : 0;
}

bool split_shadowed_dots(std::span<const OutlineGroup> groups, const GroupFits& fits, double noise_variance_lsb2,
                         std::array<bool, kDotCount>& split) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    if (!groups[i].whole_dot || !fit.usable) continue;
    if (variance_of(fit) > kShadowVariance * noise_variance_lsb2 + square(kModelMisfit * fit.contrast_lsb)) {
      any = any || !split[groups[i].dot];
      split[groups[i].dot] = true;
    }
  }
  return any;
}

}  // namespace ninedot
