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
// The contrast of outlines is this quantile of the pixels' in groups of any contrast: what hides half of a landmark has
// some of its own, and is cut into more groups than dots in sight are.
constexpr double kContrastQuantile = 0.65;
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
// What an sRGB curve, 1.055 L^(1/2.4) - 0.055, takes off each grey level that is in proportion to how it changes.
constexpr double kToe_lsb = 0.055 * 255;
constexpr double kSameInk = 0.1;     // by so much the ring's dots may differ: more is light, or other inks
constexpr int kLeastWholeDots = 5;   // more than half of a landmark's
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

/// Of a group.
struct Counted {
  double value;
  int pixels;
};

/// What the groups that show outlines have in common.
struct Typical {
  double contrast_lsb, paper_lsb, noise_variance_lsb2;
};

/// The value that `share` of the pixels lie below; reorders them.
double quantile_of_pixels(std::span<Counted> values, double share) noexcept {
  if (values.empty()) return 0;
  std::ranges::sort(values, {}, &Counted::value);
  double left = 0;
  for (const Counted& one : values) left += share * one.pixels;
  for (const Counted& one : values)
    if ((left -= one.pixels) < 0) return one.value;
  return values.back().value;
}

Typical typical_of(std::span<const OutlineGroup> groups, const GroupFits& fits) noexcept {
  std::array<Counted, kMaxGroups> values;
  std::array<double, kMaxGroups> variances;
  std::size_t count = 0;
  for (std::size_t i = 0; i < groups.size(); ++i)
    if (fits[i].usable && fits[i].contrast_lsb >= kLeastContrast_lsb)
      values[count++] = {fits[i].contrast_lsb, groups[i].count};
  Typical typical{quantile_of_pixels(std::span(values).first(count), kContrastQuantile), 0, 0};
  count = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!fits[i].usable || fits[i].contrast_lsb < kLeastContrastShare * typical.contrast_lsb) continue;
    values[count] = {fits[i].paper_lsb, groups[i].count};
    variances[count++] = variance_of(fits[i]);
  }
  typical.paper_lsb = quantile_of_pixels(std::span(values).first(count), kContrastQuantile);
  typical.noise_variance_lsb2 =
      std::max(quantile(std::span(variances).first(count), kNoiseQuantile), kRoundingVariance_lsb2);
  return typical;
}

/// What the groups' places about the model's say of the model's own faults.
struct ModelFaults {
  double factor = 1;        ///< of each group's variance
  double variance_px2 = 0;  ///< added to each group's
};

/// Scatter of the groups' places about the model's beyond what noise explains. Warped sheets and shadows displace all
/// groups alike, whatever their size: a variance that is added (DerSimonian & Laird, "Meta-analysis in clinical
/// trials", Controlled Clinical Trials 7 (1986): the excess of the weighted squares over their expectation). A colour
/// camera's pattern displaces each by a share of what noise does: a factor (Birge, "The calculation of errors by the
/// method of least squares", Phys. Rev. 40 (1932)). The likelier one is taken: P9 is larger than the others, and tells.
/// A group is moved along and across and grown (whole dots), or shifted.
ModelFaults model_faults(std::span<const OutlineGroup> groups, const GroupFits& fits, const Typical& typical) noexcept {
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
      constexpr std::array<Eigen::Index, 2> kMoves{3, 5};  // translation along the sheet's axes
      const Eigen::Matrix2d N = fit.normal(kMoves, kMoves);
      const Eigen::Vector2d g = fit.gradient(kMoves);
      d = {g.dot(N.ldlt().solve(g)) / typical.noise_variance_lsb2, d.information, 2};
    }
    const double by_light = 1 + fit.light_px2 * d.information;
    d.chi2 /= by_light, d.information /= by_light;
    per_freedom[displaced.size()] = d.chi2 / d.freedom;
    (void)displaced.try_push_back(d);  // no more of them than groups
  }
  const double most = kOutlierChi2 * std::max(quantile(std::span(per_freedom).first(displaced.size()), 0.5), 1.0);
  double excess = kPoseUnknowns, information = 0, freedoms = -kPoseUnknowns, chi2 = 0;
  int whole_dots = 0;
  for (const Displaced& d : displaced) {
    if (!(d.chi2 < most * d.freedom)) continue;
    excess += d.chi2 - d.freedom;
    information += d.freedom * d.information;
    chi2 += d.chi2;
    freedoms += d.freedom;
    whole_dots += d.freedom > 1;
  }
  if (!(information > 0 && excess > 0)) return {};
  // The variance of Student's distribution of so many degrees of freedom: the factor itself is uncertain.
  const double added_px2 = excess / information, factor = std::max(chi2 / std::max(freedoms - 2, 1.0), 1.0);
  double added_is_likelier = 0;  // twice the logarithm of the odds
  for (const Displaced& d : displaced) {
    if (!(d.chi2 < most * d.freedom)) continue;
    const double added = 1 + added_px2 * d.information;
    added_is_likelier += d.freedom * std::log(factor / added) + d.chi2 * (1 / factor - 1 / added);
  }
  // A pattern of pixels displaces nothing that is ten times their size.
  if (added_is_likelier > 0 || whole_dots < kLeastWholeDots) return {1, added_px2};
  return {factor, 0};
}

bool shows_an_outline(const GroupFit& fit, const Typical& typical) noexcept {
  if (!fit.usable) return false;
  const double light = std::clamp(fit.paper_lsb / std::max(typical.paper_lsb, 1.0), kDarkestLight, kBrightestLight);
  return fit.contrast_lsb >= std::max(kLeastContrast_lsb, kLeastContrastShare * typical.contrast_lsb * light);
}

/// Of one dot's outline.
struct DotLight {
  double paper_lsb = 0, contrast_lsb = 0;
};

/// By pixels; of a dot none of whose outline is there, 0.
std::array<DotLight, kDotCount> lights_of_dots(std::span<const OutlineGroup> groups, const GroupFits& fits,
                                               const OutlineWeights& weights) noexcept {
  std::array<DotLight, kDotCount> lights;
  std::array<int, kDotCount> pixels{};
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!weights.outline_there[i]) continue;
    DotLight& light = lights[groups[i].dot];
    light.paper_lsb += groups[i].count * fits[i].paper_lsb;
    light.contrast_lsb += groups[i].count * fits[i].contrast_lsb;
    pixels[groups[i].dot] += groups[i].count;
  }
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (pixels[dot] > 0) lights[dot].paper_lsb /= pixels[dot], lights[dot].contrast_lsb /= pixels[dot];
  return lights;
}

}  // namespace

void weigh_groups(std::span<const OutlineGroup> groups, const GroupFits& fits, double shift_floor_px,
                  OutlineWeights& weights) noexcept {
  const Typical typical = typical_of(groups, fits);
  weights.noise_variance_lsb2 = typical.noise_variance_lsb2;
  weights.fit = {typical.contrast_lsb, typical.paper_lsb, std::sqrt(typical.noise_variance_lsb2)};
  const ModelFaults faults = model_faults(groups, fits, typical);
  double sum_weight = 0, sum_shift = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    weights.weight[i] = 0;
    weights.outline_there[i] = false;
    if (!shows_an_outline(fit, typical)) continue;
    const double allowed_lsb2 = kNoiseSlack * typical.noise_variance_lsb2 + square(kModelMisfit * fit.contrast_lsb);
    const double noise_px2 = typical.noise_variance_lsb2 / fit.shift_information;
    const double expected_px2 = faults.factor * (noise_px2 + fit.light_px2) + faults.variance_px2;
    const double u2 =
        fit.shift_px * fit.shift_px / (square(kShiftSigmas) * (expected_px2 + shift_floor_px * shift_floor_px));
    double trust = 1 / ((1 + u2) * (1 + u2));
    const double misfit = std::max(variance_of(fit) / allowed_lsb2, 1.0);
    weights.outline_there[i] = trust / std::max(misfit * misfit / kSpoiledLight, 1.0) > kThereTrust;
    trust /= misfit * misfit;
    // As certain as each is: a dot that hardly shows is off by much, and says little.
    sum_weight += trust / expected_px2;
    sum_shift += trust * fit.shift_px * fit.shift_px / expected_px2;
    weights.weight[i] = trust * noise_px2 / expected_px2;
  }
  weights.rms_px = sum_weight > 0 ? std::sqrt(sum_shift / sum_weight) : 0;
}

float ink_share_of(const OutlineFit& fit) noexcept {
  const double ink_lsb = fit.paper_lsb - fit.contrast_lsb;
  return static_cast<float>(std::clamp((ink_lsb + kToe_lsb) / (fit.paper_lsb + kToe_lsb), 0.0, 1.0));
}

void bend_tones(std::span<const OutlineGroup> groups, const GroupFits& fits, const OutlineWeights& weights,
                std::array<ToneBend, kDotCount>& bends) noexcept {
  const auto lights = lights_of_dots(groups, fits, weights);
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (lights[dot].contrast_lsb > 0) bends[dot] = srgb_bend(lights[dot].paper_lsb, lights[dot].contrast_lsb);
}

double centre_ink(std::span<const OutlineGroup> groups, const GroupFits& fits, const OutlineWeights& weights) noexcept {
  const auto lights = lights_of_dots(groups, fits, weights);
  if (std::ranges::any_of(lights, [](const DotLight& light) { return !(light.paper_lsb > 0); })) return 1;
  const auto ink = [&](std::size_t dot) { return lights[dot].contrast_lsb / lights[dot].paper_lsb; };
  std::array<double, kRingDotCount> ring;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) ring[dot] = ink(dot);
  std::ranges::sort(ring);
  const double usual = ring[kRingDotCount / 2];
  if (ring.front() < (1 - kSameInk) * usual || ring.back() > (1 + kSameInk) * usual) return 1;
  return ink(kCentreDot) / usual;
}

bool is_shadowed(double variance_lsb2, double contrast_lsb, double noise_variance_lsb2) noexcept {
  return variance_lsb2 > kShadowVariance * noise_variance_lsb2 + square(kModelMisfit * contrast_lsb);
}

}  // namespace ninedot
