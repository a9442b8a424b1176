#include "pose/outline_refiner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

// Stage by stage: look at the pixels along the outlines where the state says they are, weigh their groups, step. An
// early stage trusts the state less; only late ones may end.

namespace ninedot {
namespace {

constexpr std::size_t kMaxPixels = 12000;  // nine outlines of 2000 px in all, in a band of 6 px; beyond, thinned

struct Stage {
  /// What the outlines may be off by: 1.5 px is what centroids of blobs leave at worst; Newton's method squares it over
  /// the blur from one step to the next; what lens and tone curve leave at last is 0.1 px.
  double shift_floor_px;
  bool may_split;   ///< dots that a shadow's edge crosses are found while the state is good, and early enough to settle
  bool may_settle;  ///< outliers are told by the last floor
};
constexpr std::array<Stage, 7> kStages{{{1.5, false, false},
                                        {0.6, true, false},
                                        {0.12, true, true},
                                        {0.12, true, true},
                                        {0.12, false, true},
                                        {0.12, false, true},
                                        {0.12, false, true}}};
constexpr int kRoughStage = 0, kCloseStage = 1;
constexpr int kUsualStages = 3;   // that follow the rough one
constexpr int kHopelessFrom = 3;  // after so many steps from a close start a pose fits nearly as well as it will
constexpr int kMostThinned = 3;   // every third: half the precision at most
// What is left of the pixels by thinning: below, groups would have hardly more pixels than unknowns of their own, and
// fit whatever is there.
constexpr int kLeastThinned = 2500;
constexpr int kRoughThinning = 3;  // of the pixels, while the pose is off by tenths of a pixel
// A stage that is not the last may look at every second pixel, where so many are left that what it is off by for that
// is less than what it is off by for its start.
constexpr int kEarlyThinning = 2, kLeastEarly = 600;
constexpr double kRoughBand_px = 3.5;  // a rough start is good to two pixels, and half of the blur's reach on top
// Pixels up to this many sigmas of the blur from an outline: beyond, their grey levels hardly depend on its place.
// Measured over the accuracy page's conditions (`accuracy --out`): 36 of 45 rows came nearer to the bound than
// with 2.5.
constexpr double kBandPerSigma = 3.1, kBandSlack_px = 0.3, kLeastBand_px = 1.8, kMostBand_px = 8;
constexpr double kMovedAway_px = 0.25;  // a step, or a change of the band, after which other pixels belong to it
// Newton's error after a step is about its square over the blur: below these a step leaves less than a tenth of a
// standard deviation, and no more than 0.003 px. With 0.03 px as standard deviation the former is a chi^2 of 3; with
// more, the pixels are few and a stage is cheap.
constexpr double kLastStep_chi2 = 3, kLastStep_px = 0.05, kLeftSigmas = 0.1;
// Offset, blur and tone move along a valley together: until the whole step gains little, or the pose has settled. (A
// step along a landmark that was followed gains 2 in the median and 12 in one of ten, one whose blur was off 300 and
// more.)
constexpr double kLastGain_chi2 = 10, kLastTone_chi2 = 0.3;
// What an expectation is off by, as its first step tells: at most (the blur: further away the step's direction is a
// guess), and where its groups may be weighed as if it were right (the floor of the last stages, twice). A second step
// that is still as long says that the first one led nowhere.
constexpr double kExpectedReach_px = 1, kExpectedClose_px = 0.25, kExpectedSecond_px = 0.7;
// Of the noise of a pixel: with less contrast than that there is nothing where outlines were expected, and the steps go
// about in noise, each as short as those along a landmark. (The dimmest landmark that is searched for has four.)
constexpr double kNoInk_sigmas = 1;
// Outlines that are not where they were expected look blurred, and take three times the pixels at last. Motion that
// begins between two frames doubles the band at most.
constexpr double kExpectedWider = 2;
// By so much an edge of light that no model explains may seem to move each of a dot's sectors: 1 sigma.
constexpr double kCutMoves_px = 0.05;
// To look for a shadow's edge costs as much as to fit so many times the dot's pixels.
constexpr int kNewEdge = 8, kMovedEdge = 2;
// The weights were of the place before a step: where the step before it was longer than this, they are out of date.
constexpr double kCalm_px = 0.03;
constexpr double kHeldSigma = 1e-3, kFreeSigma = 1e3;  // of offset [px] and blur [px^2] in one step
constexpr double kOffsetSigma_px = 0.35;               // prior: an sRGB curve moves edges by 0.3 px (METHOD, section 3)
constexpr double kHarmonicSigma_px2 = 0.6;             // prior of the blur's direction: of the mean blur's size
// Its tail is as wide as that of Student's distribution with one degree of freedom (in two dimensions: the root of
// three). A camera that moves draws lines of any length, and a prior that won't have them makes fits take them for the
// foreshortening of the other planar solution.
constexpr double kTail = 1.7;
constexpr double kSmearShare = 0.2;  // of the smear that is foretold: with a motion that is known to a tenth
// Prior of the tone: between a linear picture and one with an sRGB curve, once the blur is wider than kNoTone_px2; from
// kAllTone_px2 on as wide as that. Of a sharper picture it would be the offset once more, and take from the pose what
// tells them apart.
constexpr double kMeanTone = 0.5, kToneSigma = 0.5, kHeldToneSigma = 0.01;
constexpr double kNoTone_px2 = 0.8, kAllTone_px2 = 1.2;
// Then the offset is what ink spreads on paper: with both free, and the blur, steps go to and fro along a valley that
// leaves the pose where it is.
constexpr double kDotGainSigma_px = 0.1;
// What an sRGB curve that is taken for an offset and a Gaussian makes of the latter's variance, beside kToneOffset.
constexpr double kToneBlur = 0.19;
// Until the first fit: of ink and paper in usual light. [LSB]
constexpr double kUsualPaper_lsb = 190, kUsualContrast_lsb = 145;
constexpr double kMostContrast_lsb = 255;                      // a fit of what is no dot asks for any
constexpr double kMeanBlur_px2 = 0.7, kMeanBlurSigma_px2 = 3;  // prior: 0.84 px, small sensors; up to 2.5 px at 2 sigma

double band_of(const OutlineState& state) noexcept {
  return std::clamp(kBandPerSigma * std::sqrt(state.widest_px2()) + kBandSlack_px, kLeastBand_px, kMostBand_px);
}

const Stage& stage_of(int stage) noexcept { return kStages[static_cast<std::size_t>(stage)]; }

}  // namespace

OutlineRefiner::OutlineRefiner(const CameraModel& camera, const LandmarkGeometry& landmark, const RayTable& rays,
                               bool regards_walls)
    : camera_(camera),
      landmark_(landmark),
      rays_(rays),
      usual_bend_(srgb_bend(kUsualPaper_lsb, kUsualContrast_lsb)),
      pixels_(kMaxPixels) {
  pixels_.regards_walls = regards_walls;
}

const OptimiserStatistics& OutlineRefiner::refine(const ImageView& luma, const OutlineState& start, Start quality,
                                                  double warp_px, int& pixels, Light light,
                                                  double hopeless_lsb) noexcept {
  luma_ = luma;
  light_ = light;
  pixels_left_ = pixels;
  state_ = start;
  quality_ = quality;
  warp_px_ = warp_px;
  hopeless_lsb_ = hopeless_lsb;
  cuts_.fill(Cut::kBySize);
  contrasts_lsb_.fill(0);
  pixels_.light_edges.fill(std::nullopt);
  tone_share_ = light == Light::kFull ? tone_share() : 0;
  pixels_.has_tone = tone_share_ > 0;
  pixels_.shows_light = false;
  if (pixels_.has_tone) guess_tone();
  look_ = {};
  // What is about where it was foretold is seen as it was; of a guess that is not, slopes of the ink are misfit.
  pixels_.ink_share = quality == Start::kExpected ? kUsualInkShare : 0;
  last_step_px_ = 0;
  start_band_px_ = band_of(start);
  const int first = quality == Start::kRough ? kRoughStage : kCloseStage;
  statistics_ = gauss_newton(*this, first, static_cast<int>(kStages.size()));
  // What was foretold and not seen has to settle.
  if (quality == Start::kExpected && statistics_.stopped == Stopped::kOutOfStages)
    statistics_.stopped = Stopped::kLedNowhere;
  pixels = pixels_left_;
  return statistics_;
}

bool OutlineRefiner::is_first_of_expectation(int stage) const noexcept {
  return quality_ == Start::kExpected && stage == kCloseStage;
}

double OutlineRefiner::tone_share() const noexcept {
  // What a colour camera's pattern leaves of the outlines says nothing of the curve.
  if (luma_.has_pattern) return 0;
  return std::clamp((state_.widest_px2() - kNoTone_px2) / (kAllTone_px2 - kNoTone_px2), 0.0, 1.0);
}

/// From where an offset that has been taken for all of it is, there is no way down.
void OutlineRefiner::guess_tone() noexcept {
  pixels_.tone_bends.fill(usual_bend_);
  const double sigma_px = std::sqrt(state_.blur_px2);
  state_.tone = tone_share_ * std::clamp(state_.offset_px / (kToneOffset * sigma_px), 0.0, 1.0);
  state_.offset_px -= state_.tone * kToneOffset * sigma_px;
  state_.blur_px2 *= 1 - state_.tone * kToneBlur;
}

bool OutlineRefiner::look_again_if_stale(int stage) noexcept {
  const double band_px = stage == kRoughStage ? std::max(kRoughBand_px, band_of(state_)) : band_of(state_);
  const bool stale = look_.thinned || look_.split_since || look_.moved_px > kMovedAway_px ||
                     std::abs(band_px - look_.band_px) > kMovedAway_px;
  const bool turns_to_light = luma_.has_pattern && !pixels_.shows_light && Smear(state_).parts > 1;
  if (!stale && !turns_to_light) return true;
  if (turns_to_light) {  // what the curve did to the outlines goes with it
    pixels_.shows_light = true;
    state_.offset_px = 0;
    contrasts_lsb_.fill(0);
  }
  look_ = {band_px, 0, stage == kRoughStage, false};
  const auto collect = [&](int thinning) {
    collect_outline_pixels(luma_, camera_, rays_, landmark_, state_.T_camera_landmark, band_px, thinning, cuts_,
                           state_.motion, pixels_);
    if (pixels_.shows_light) straighten_tone({pixels_.luma.data(), pixels_.count});
    pixels_left_ -= pixels_.work_px;
  };
  collect(look_.thinned ? kRoughThinning : 1);
  // Rather every second pixel to the end than all of them half the way.
  const auto count = static_cast<int>(pixels_.count);
  const int left = std::max(pixels_left_, 1);
  const int thinning = std::min((count * kUsualStages + left - 1) / left, kMostThinned);
  if (!look_.thinned && thinning > 1 && count / thinning >= kLeastThinned) collect(thinning);
  return !pixels_.groups.empty();
}

bool OutlineRefiner::linearise(int stage) noexcept {
  if (pixels_left_ <= 0 || !look_again_if_stale(stage)) return false;
  const bool is_early = stage == kCloseStage && quality_ != Start::kExpected &&
                        pixels_.count >= std::size_t{kEarlyThinning} * kLeastEarly;
  const std::size_t every = is_early ? kEarlyThinning : 1;
  pixels_left_ -= static_cast<int>(pixels_.count / every);
  linearised_at_ = state_;
  const auto groups = pixels_.groups.span();
  pixels_.are_smeared = Smear(state_).parts > 1;
  // Dots that run together hide each other's ink: what each has is told once that of its neighbours is.
  if (pixels_.are_smeared && std::ranges::all_of(contrasts_lsb_, [](float contrast) { return contrast == 0; }))
    fit_groups(every);
  fit_groups(every);
  weigh_groups(groups, fits_, std::max(stage_of(stage).shift_floor_px, warp_px_), weights_);
  // An outline that is not where it is looked for fits as badly as one that a shadow's edge crosses.
  look_.split_since = stage_of(stage).may_split && !is_first_of_expectation(stage) && follow_shadows();
  return true;
}

void OutlineRefiner::fit_groups(std::size_t every) noexcept {
  const auto groups = pixels_.groups.span();
  if (pixels_.are_smeared) gather_ink_of_others(landmark_, state_, contrasts_lsb_, pixels_);
  contrasts_lsb_.fill(0);
  GroupFitter fitter(pixels_, landmark_, state_, Asked::kState);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::size_t dot = groups[g].dot;
    std::optional<LightEdge>& edge = pixels_.light_edges[dot];
    // Where the outline is now, the edge is elsewhere too.
    if (groups[g].whole_dot && edge) {
      pixels_left_ -= kMovedEdge * groups[g].count;
      if (const auto moved = fitter.find_edge(groups[g], &*edge)) edge = moved;
    }
    fitter.fit(groups[g], fits_[g], every);
    if (light_ == Light::kFull && cuts_[dot] == Cut::kSectors) fits_[g].light_px2 = kCutMoves_px * kCutMoves_px;
    if (groups[g].whole_dot && fits_[g].usable)
      contrasts_lsb_[dot] = static_cast<float>(std::clamp(fits_[g].contrast_lsb, 0.0, kMostContrast_lsb));
  }
}

/// Finds the edges of shadows that cross dots; cuts into sectors where one edge is not enough.
/// \return  whether there is something new
bool OutlineRefiner::follow_shadows() noexcept {
  bool is_new = false;
  GroupFitter fitter(pixels_, landmark_, state_, Asked::kLightOnly);
  const auto groups = pixels_.groups.span();
  const double noise_lsb2 = weights_.noise_variance_lsb2;
  const auto is_dark = [&](const GroupFit& fit) {
    return fit.usable && is_shadowed(fit.squared_residuals / fit.degrees_of_freedom, fit.contrast_lsb, noise_lsb2);
  };
  for (std::size_t g = 0, end; g < groups.size(); g = end) {
    // The groups of a dot come one after another, and so do their pixels.
    OutlineGroup dot = groups[g];
    bool any_dark = false;
    for (end = g; end < groups.size() && groups[end].dot == dot.dot; ++end) any_dark = any_dark || is_dark(fits_[end]);
    Cut& cut = cuts_[dot.dot];
    const bool may_have_edge = light_ == Light::kFull && semi_minor_px(dot.dot) < kWholeDotBelow_px;
    if (!any_dark || cut == Cut::kSectors || !(dot.whole_dot || may_have_edge)) continue;
    dot.count = groups[end - 1].first + groups[end - 1].count - dot.first;
    std::optional<LightEdge>& edge = pixels_.light_edges[dot.dot];
    const bool has_none = edge || dot.at_paper_edge || !may_have_edge;
    if (!has_none) pixels_left_ -= kNewEdge * dot.count;
    edge = has_none ? std::nullopt : fitter.find_edge(dot, nullptr);
    if (edge && is_shadowed(edge->variance_lsb2, weights_.fit.contrast_lsb, noise_lsb2)) edge.reset();
    cut = edge ? Cut::kWhole : Cut::kSectors;
    is_new = is_new || edge || dot.whole_dot;
  }
  return is_new;
}

StepVerdict OutlineRefiner::solve(int stage, Step& step) noexcept {
  if (!is_first_of_expectation(stage))
    return solve_equations(kFreeSigma, step) ? StepVerdict::kGoOn : StepVerdict::kUndetermined;
  // Outlines that are off look blurred. Offset and blur are the camera's: they wait until the pose is about right.
  if (!solve_equations(kHeldSigma, step)) return StepVerdict::kUndetermined;
  const double off_px = step_px(step);
  if (off_px > kExpectedReach_px) return StepVerdict::kLedNowhere;
  expectation_is_close_ = off_px < kExpectedClose_px;
  if (!expectation_is_close_) return StepVerdict::kGoOn;
  weigh_groups(pixels_.groups.span(), fits_, std::max(kStages.back().shift_floor_px, warp_px_), weights_);
  look_.split_since = follow_shadows();
  return solve_equations(kFreeSigma, step) ? StepVerdict::kGoOn : StepVerdict::kUndetermined;
}

bool OutlineRefiner::is_blank() const noexcept {
  return weights_.fit.contrast_lsb < kNoInk_sigmas * std::sqrt(weights_.noise_variance_lsb2);
}

void OutlineRefiner::apply(const Step& step) noexcept {
  const OutlineState before = state_;
  state_.apply(step);
  last_step_ = moved_ = step;
  moved_.tail<4>() << state_.blur_px2 - before.blur_px2, state_.blur_cos_px2 - before.blur_cos_px2,
      state_.blur_sin_px2 - before.blur_sin_px2, state_.tone - before.tone;
  gain_ = moved_.dot(2 * gradient_of_pixels_ - of_pixels_ * moved_);
}

/// What the groups say where the last step has led, by their equations: no pixel is looked at.
void OutlineRefiner::foretell_fits() noexcept {
  Step moved = moved_;  // along the sheet's axes
  for (const Eigen::Index at : {0, 3})
    moved.segment<3>(at) = linearised_at_.T_camera_landmark.rotation.transpose() * moved_.segment<3>(at);
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    GroupFit& fit = fits_[i];
    if (!fit.usable) continue;
    const UnknownVector change = fit.normal * moved;
    fit.squared_residuals = std::max(fit.squared_residuals - moved.dot(2 * fit.gradient - change), 0.0);
    fit.gradient -= change;
    fit.shift_px = fit.gradient(6) / fit.shift_information;
  }
  linearised_at_ = state_;
}

/// After a step that leaves little, but was taken with the weights of where a longer one began: as another stage, by
/// what the groups' equations foretell. \return  whether it changes as little
bool OutlineRefiner::weigh_again(int stage) noexcept {
  foretell_fits();
  weigh_groups(pixels_.groups.span(), fits_, std::max(stage_of(stage).shift_floor_px, warp_px_), weights_);
  Step step;
  if (!solve_equations(kFreeSigma, step)) return false;
  const double by_px = step_px(step);
  apply(step);
  look_.moved_px += by_px;
  last_step_px_ = by_px;
  return step_chi2(step) < kLastStep_chi2 && by_px < kCalm_px && state_.T_camera_landmark.translation_m.z() > 0;
}

StepVerdict OutlineRefiner::take(int stage, const Step& step) noexcept {
  const double blur_before_px = std::sqrt(state_.blur_px2);
  apply(step);
  if (!(state_.T_camera_landmark.translation_m.z() > 0)) return StepVerdict::kUndetermined;
  const double by_px = step_px(step);
  const bool first_of_expectation = is_first_of_expectation(stage), expected = quality_ == Start::kExpected;
  if (expected && !first_of_expectation && by_px > kExpectedSecond_px) return StepVerdict::kLedNowhere;
  if (expected && is_blank()) return StepVerdict::kLedNowhere;
  if (stage >= kHopelessFrom && weights_.fit.residual_lsb > hopeless_lsb_) return StepVerdict::kLedNowhere;
  if (expected && band_of(state_) > kExpectedWider * start_band_px_) return StepVerdict::kLedNowhere;
  const bool is_calm = !expected || last_step_px_ < kCalm_px;
  const bool is_fine = first_of_expectation ? expectation_is_close_ : stage_of(stage).may_settle;
  look_.moved_px += by_px;
  last_step_px_ = by_px;
  const double sigma_px = 1 / std::sqrt(information_(6, 6));
  const bool leaves_little =
      step_chi2(step) < kLastStep_chi2 || by_px * by_px < kLeftSigmas * sigma_px * blur_before_px;
  const bool is_same_tone = !pixels_.has_tone || gain_ < kLastGain_chi2 || step_chi2(step) < kLastTone_chi2;
  const bool is_there = is_fine && !look_.split_since && leaves_little && by_px < kLastStep_px && is_same_tone;
  // Where the whole step gains much, blur or offset were off, and what the equations foretell is not what is there.
  if (is_there && (is_calm || (gain_ < kLastGain_chi2 && weigh_again(stage)))) return StepVerdict::kSettled;
  pixels_.ink_share = ink_share_of(weights_.fit);
  if (pixels_.has_tone && stage == kCloseStage) bend_tones(pixels_.groups.span(), fits_, weights_, pixels_.tone_bends);
  return StepVerdict::kGoOn;
}

double OutlineRefiner::step_chi2(const Step& step) const noexcept {
  const Eigen::Matrix<double, kPoseUnknowns, 1> pose_step = step.head<kPoseUnknowns>();
  return pose_step.dot(information_.topLeftCorner<kPoseUnknowns, kPoseUnknowns>() * pose_step);
}

double OutlineRefiner::step_px(const Step& step) const noexcept {
  return std::sqrt(step_chi2(step) / information_(6, 6));  // (6, 6): of moving all outlines by a pixel
}

/// The normal equations of all groups and the priors; keeps the matrix. \return false when they determine no step
/// \param nuisance_sigma  how far offset and blur may go, beside their priors
bool OutlineRefiner::solve_equations(double nuisance_sigma, Step& step) noexcept {
  information_.setZero();
  UnknownVector b = UnknownVector::Zero();
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    if (weights_.weight[i] <= 0) continue;
    information_ += weights_.weight[i] * fits_[i].normal;
    b += weights_.weight[i] * fits_[i].gradient;
  }
  information_ /= weights_.noise_variance_lsb2;
  b /= weights_.noise_variance_lsb2;
  // From the sheet's axes to the camera's.
  const Eigen::Matrix3d& R = state_.T_camera_landmark.rotation;
  for (const Eigen::Index at : {0, 3}) {
    information_.middleRows<3>(at) = (R * information_.middleRows<3>(at)).eval();
    b.segment<3>(at) = (R * b.segment<3>(at)).eval();
  }
  for (const Eigen::Index at : {0, 3})
    information_.middleCols<3>(at) = (information_.middleCols<3>(at) * R.transpose()).eval();
  of_pixels_ = information_, gradient_of_pixels_ = b;
  const auto prior = [&](int unknown, double value, double mean, double sigma) {
    information_(unknown, unknown) += 1 / (sigma * sigma);
    b(unknown) += (mean - value) / (sigma * sigma);
  };
  prior(6, state_.offset_px, 0, std::lerp(kOffsetSigma_px, kDotGainSigma_px, tone_share_));
  const Eigen::Vector3d smear = smear_px2(state_, camera_.fx_px);
  const double smear_sigma = kSmearShare * smear(0);
  prior(7, state_.blur_px2, kMeanBlur_px2 + smear(0), std::hypot(kMeanBlurSigma_px2, smear_sigma));
  const double off_px2 = std::hypot(state_.blur_cos_px2 - smear(1), state_.blur_sin_px2 - smear(2));
  const double harmonic_sigma = std::hypot(kHarmonicSigma_px2, smear(0) > 0 ? smear_sigma : off_px2 / kTail);
  prior(8, state_.blur_cos_px2, smear(1), harmonic_sigma);
  prior(9, state_.blur_sin_px2, smear(2), harmonic_sigma);
  prior(kToneUnknown, state_.tone, tone_share_ * kMeanTone, kHeldToneSigma + tone_share_ * kToneSigma);
  for (int unknown = kPoseUnknowns; unknown < kUnknowns; ++unknown) prior(unknown, 0, 0, nuisance_sigma);
  const Eigen::LDLT<UnknownMatrix> ldlt(information_);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return false;
  step = ldlt.solve(b);
  return step.allFinite();
}

}  // namespace ninedot
