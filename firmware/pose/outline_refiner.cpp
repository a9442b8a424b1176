#include "pose/outline_refiner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

constexpr std::size_t kMaxPixels = 12000;
constexpr int kMaxSteps = 7;
constexpr int kRoughThinning = 3;      // of the pixels, while the pose is off by tenths of a pixel
constexpr double kRoughBand_px = 3.5;  // a rough start is good to two pixels
constexpr double kBandPerSigma = 3.1;  // beyond, an outline's grey levels no longer depend on its place
// What the outlines may be off by before the first, the second and all further steps.
constexpr std::array<double, 3> kShiftFloor_px{1.5, 0.6, 0.12};
constexpr double kMovedAway_px = 0.25;  // a step, or a change of the band, after which other pixels belong to it
// Newton's error after a step is about its square over the blur: below these a step leaves less than a tenth of a
// standard deviation, and no more than 0.003 px.
constexpr double kLastStep_chi2 = 3;
constexpr double kLastStep_px = 0.05;
// What an expectation is off by, as its first step tells: at most, and where its groups may be weighed as if it were
// right. A second step that is still as long says that the first one led nowhere.
constexpr double kExpectedReach_px = 1, kExpectedClose_px = 0.25, kExpectedSecond_px = 0.7;
constexpr double kCalm_px = 0.03;
constexpr double kHeldSigma = 1e-3, kFreeSigma = 1e3;  // of offset [px] and blur [px^2] in one step
constexpr double kOffsetSigma_px = 0.35;               // prior: an sRGB curve moves edges by 0.3 px (METHOD, section 3)
constexpr double kHarmonicSigma_px2 = 0.6;             // prior of the blur's direction
constexpr double kMeanBlur_px2 = 0.7, kMeanBlurSigma_px2 = 3;

/// The value that `share` of the values lie below; reorders them.
double quantile(std::span<double> values, double share) noexcept {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double band_of(const OutlineState& state) noexcept {
  const double sigma_px = std::sqrt(state.blur_px2 + std::hypot(state.blur_cos_px2, state.blur_sin_px2));
  return std::clamp(kBandPerSigma * sigma_px + 0.3, 1.8, 8.0);
}

}  // namespace

OutlineRefiner::OutlineRefiner(const CameraModel& camera, const LandmarkGeometry& landmark, const RayTable& rays)
    : camera_(camera), landmark_(landmark), rays_(rays), pixels_(kMaxPixels) {}

void OutlineRefiner::collect(const ImageView& luma, double band_px, int thinning) noexcept {
  collect_outline_pixels(luma, camera_, rays_, landmark_, state_.T_camera_landmark, band_px, thinning, split_, pixels_);
}

bool OutlineRefiner::refine(const ImageView& luma, const OutlineState& start, Start quality, double warp_px) noexcept {
  state_ = start;
  split_.fill(false);
  const int first = quality == Start::kRough ? 0 : 1;
  double collected_band_px = 0, moved_px = 0;
  double last_by_px = 0;
  bool just_split = false, thinned = false, settled = false;
  for (int i = first; i < kMaxSteps; ++i) {
    const double band_px = i == 0 ? kRoughBand_px : band_of(state_);
    const bool stale =
        thinned || just_split || moved_px > kMovedAway_px || std::abs(band_px - collected_band_px) > kMovedAway_px;
    if (stale) {
      thinned = i == 0;
      collect(luma, band_px, thinned ? kRoughThinning : 1);
      collected_band_px = band_px;
      moved_px = 0;
      if (pixels_.groups.empty()) return false;
    }
    for (std::size_t g = 0; g < pixels_.groups.size(); ++g)
      fit_group(pixels_, pixels_.groups[g], landmark_, state_, true, fits_[g]);
    weigh_groups(std::max(kShiftFloor_px[static_cast<std::size_t>(std::min(i, 2))], warp_px));
    // An outline that is not where it is looked for fits as badly as one that a shadow's edge crosses.
    const bool unsure = quality == Start::kExpected && i == first;
    just_split = !unsure && i >= 1 && i <= 3 && split_shadowed_dots();

    // Outlines that are off look blurred. Offset and blur are the camera's: they wait until the pose is about right.
    UnknownVector step;
    if (!solve_step(unsure ? kHeldSigma : kFreeSigma, step)) return false;
    bool fine = i >= 2;  // outliers are told by the last floor
    if (unsure) {
      const double off_px = step_px(step);
      if (off_px > kExpectedReach_px) return false;
      fine = off_px < kExpectedClose_px;
      if (fine) {
        weigh_groups(std::max(kShiftFloor_px[2], warp_px));
        just_split = split_shadowed_dots();
        if (!solve_step(kFreeSigma, step)) return false;
      }
    }
    state_.apply(step);
    if (!(state_.T_camera_landmark.translation_m.z() > 0)) return false;
    const double by_px = step_px(step);
    if (quality == Start::kExpected && i > first && by_px > kExpectedSecond_px) return false;
    moved_px += by_px;
    // The weights were of the place before this step: where the step before it was long, they are out of date.
    const bool calm = quality != Start::kExpected || last_by_px < kCalm_px;
    last_by_px = by_px;
    settled = fine && calm && !just_split && step_chi2(step) < kLastStep_chi2 && by_px < kLastStep_px;
    if (settled) break;
  }
  return settled || quality != Start::kExpected;
}

double OutlineRefiner::step_chi2(const UnknownVector& step) const noexcept {
  const Eigen::Matrix<double, 6, 1> pose_step = step.head<6>();
  return pose_step.dot(information_.topLeftCorner<6, 6>() * pose_step);
}

double OutlineRefiner::step_px(const UnknownVector& step) const noexcept {
  return std::sqrt(step_chi2(step) / information_(6, 6));  // (6, 6): of moving all outlines by a pixel
}

/// The normal equations of all groups and the priors; keeps the matrix. \return false when they determine no step
/// \param nuisance_sigma  how far offset and blur may go, beside their priors
bool OutlineRefiner::solve_step(double nuisance_sigma, UnknownVector& step) noexcept {
  information_.setZero();
  UnknownVector b = UnknownVector::Zero();
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    if (weight_[i] <= 0) continue;
    information_ += weight_[i] * fits_[i].normal;
    b += weight_[i] * fits_[i].gradient;
  }
  information_ /= noise_variance_;
  b /= noise_variance_;
  const auto prior = [&](int unknown, double value, double mean, double sigma) {
    information_(unknown, unknown) += 1 / (sigma * sigma);
    b(unknown) += (mean - value) / (sigma * sigma);
  };
  prior(6, state_.offset_px, 0, kOffsetSigma_px);
  prior(7, state_.blur_px2, kMeanBlur_px2, kMeanBlurSigma_px2);
  prior(8, state_.blur_cos_px2, 0, kHarmonicSigma_px2);
  prior(9, state_.blur_sin_px2, 0, kHarmonicSigma_px2);
  for (int unknown = 6; unknown < kUnknowns; ++unknown) prior(unknown, 0, 0, nuisance_sigma);
  const Eigen::LDLT<UnknownMatrix> ldlt(information_);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return false;
  step = ldlt.solve(b);
  return step.allFinite();
}

/// Weights of all groups from their contrast, their residuals and their shift against what the state says.
/// \param shift_floor_px  what the state may still be off by: while it is, every group is shifted, and none an outlier
void OutlineRefiner::weigh_groups(double shift_floor_px) noexcept {
  constexpr double kMinContrastShare = 0.3;
  constexpr double kMinContrast_lsb = 4;
  constexpr double kNoiseQuantile = 0.35;
  std::array<double, kMaxGroups> contrasts, papers, variances;
  std::size_t count = 0;
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    const GroupFit& fit = fits_[i];
    if (!fit.usable || fit.contrast_lsb < kMinContrast_lsb) continue;
    contrasts[count] = fit.contrast_lsb;
    papers[count] = fit.paper_lsb;
    variances[count] = fit.squared_residuals / fit.degrees_of_freedom;
    ++count;
  }
  const double contrast_lsb = quantile(std::span(contrasts).first(count), 0.5);
  const double paper_lsb = quantile(std::span(papers).first(count), 0.5);
  // Not the median: half of the groups may be spoiled by shadows. A twelfth is what rounding to whole grey levels
  // leaves of a noiseless picture.
  noise_variance_ = std::max(quantile(std::span(variances).first(count), kNoiseQuantile), 1.0 / 12);

  const double model_px2 = model_variance_px2(contrast_lsb);
  double sum_weight = 0, sum_shift = 0;
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    const GroupFit& fit = fits_[i];
    double& weight = weight_[i];
    weight = 0;
    outline_there_[i] = false;
    if (!fit.usable) continue;
    const double light = std::clamp(fit.paper_lsb / std::max(paper_lsb, 1.0), 0.25, 1.5);
    if (fit.contrast_lsb < std::max(kMinContrast_lsb, kMinContrastShare * contrast_lsb * light)) continue;
    const double variance = fit.squared_residuals / fit.degrees_of_freedom;
    const double allowed = 3 * noise_variance_ + std::pow(0.02 * fit.contrast_lsb, 2);
    const double expected_px2 = noise_variance_ / fit.shift_information;
    const double u2 = fit.shift_px * fit.shift_px / (9 * (expected_px2 + model_px2 + shift_floor_px * shift_floor_px));
    double trust = 1 / ((1 + u2) * (1 + u2));
    const double misfit = std::max(variance / allowed, 1.0);
    outline_there_[i] = trust / std::max(misfit * misfit / 64, 1.0) > 0.25;
    trust /= misfit * misfit;
    sum_weight += trust;
    sum_shift += trust * fit.shift_px * fit.shift_px;
    weight = trust / (1 + model_px2 / expected_px2);
  }
  rms_px_ = sum_weight > 0 ? std::sqrt(sum_shift / sum_weight) : 0;
}

/// Variance of the groups' places about the model's beyond what noise explains: warped sheets, shadows, the model's own
/// faults. DerSimonian & Laird, "Meta-analysis in clinical trials", Controlled Clinical Trials 7 (1986): the excess of
/// the weighted squares over their expectation. A group is moved along and across and grown (whole dots), or shifted.
double OutlineRefiner::model_variance_px2(double contrast_lsb) const noexcept {
  constexpr double kOutlier = 16;  // times the median chi^2 per degree of freedom
  struct Displaced {
    double chi2, information;
    int freedom;
  };
  InlineVector<Displaced, kMaxGroups> groups;
  std::array<double, kMaxGroups> per_freedom;
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    const GroupFit& fit = fits_[i];
    if (!fit.usable || fit.contrast_lsb < 0.3 * contrast_lsb) continue;
    Displaced d{fit.shift_px * fit.shift_px * fit.shift_information / noise_variance_,
                fit.shift_information / noise_variance_, 1};
    if (pixels_.groups[i].whole_dot) {
      constexpr std::array<Eigen::Index, 3> kMoves{3, 4, 6};  // translation along the picture's axes, growth
      const Eigen::Matrix3d N = fit.normal(kMoves, kMoves);
      const Eigen::Vector3d g = fit.gradient(kMoves);
      d = {g.dot(N.ldlt().solve(g)) / noise_variance_, d.information, 3};
    }
    per_freedom[groups.size()] = d.chi2 / d.freedom;
    (void)groups.try_push_back(d);
  }
  const double most = kOutlier * std::max(quantile(std::span(per_freedom).first(groups.size()), 0.5), 1.0);
  double excess = kUnknowns, information = 0;
  for (const Displaced& d : groups) {
    if (!(d.chi2 < most * d.freedom)) continue;
    excess += d.chi2 - d.freedom;
    information += d.freedom * d.information;
  }
  return information > 0 ? std::max(excess, 0.0) / information : 0;
}

/// A dot that a shadow's edge crosses does not fit one paper and one ink. Its sectors do, but for those on the edge.
/// \return  whether there is a new one
bool OutlineRefiner::split_shadowed_dots() noexcept {
  constexpr double kMaxVariance = 2.5;  // of the noise; smooth light gives 0.7 .. 1.6
  constexpr double kMaxMisfit = 0.02;   // of the contrast: what the outline's model itself leaves over
  bool any = false;
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    const GroupFit& fit = fits_[i];
    if (!pixels_.groups[i].whole_dot || !fit.usable) continue;
    const double variance = fit.squared_residuals / fit.degrees_of_freedom;
    if (variance > kMaxVariance * noise_variance_ + std::pow(kMaxMisfit * fit.contrast_lsb, 2)) {
      any = any || !split_[pixels_.groups[i].dot];
      split_[pixels_.groups[i].dot] = true;
    }
  }
  return any;
}

bool OutlineRefiner::is_light_smooth() const noexcept {
  return std::ranges::none_of(split_, [](bool split) { return split; });
}

double OutlineRefiner::chi2_above(const OutlineState& other) const noexcept {
  double difference = 0;
  GroupFit theirs, ours;
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    if (weight_[i] <= 0) continue;
    fit_group(pixels_, pixels_.groups[i], landmark_, other, false, theirs);
    fit_group(pixels_, pixels_.groups[i], landmark_, state_, false, ours);
    difference += weight_[i] * (theirs.squared_residuals - ours.squared_residuals) / noise_variance_;
  }
  return difference;
}

std::array<double, kDotCount> OutlineRefiner::visible_share() const noexcept {
  std::array<int, kDotCount> groups{}, good{};
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    ++groups[pixels_.groups[i].dot];
    good[pixels_.groups[i].dot] += outline_there_[i];
  }
  std::array<double, kDotCount> share{};
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (groups[dot] > 0) share[dot] = static_cast<double>(good[dot]) / groups[dot];
  return share;
}

}  // namespace ninedot
