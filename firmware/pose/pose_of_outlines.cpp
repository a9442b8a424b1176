#include "pose/pose_of_outlines.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/inline_vector.h"
#include "geometry/definite_inverse.h"
#include "pose/ellipse_parameters.h"
#include "pose/outline_shape.h"
#include "pose/tilt_spread.h"

namespace ninedot {
namespace {

// Of all outlines alike, beyond noise: what rendered sRGB pictures without noise leave, and tone curves' residue.
constexpr double kCommonShift_px = 0.002;
constexpr double kHalf = 0.5;  // of its outline: a dot that shows less counts as hidden in the founding paper's levels
constexpr double kMaxMisfit = 0.3;  // of a dot's radius: what is further off is no print of the landmark
constexpr int kLeastDots = 3;       // three discs determine a plane's pose, two leave a turn about their line

// Times the picture's noise: the estimate is within a fifth of the truth, smooth light leaves 1.6 times the variance.
constexpr double kFitNoise = 2;
// Of the contrast, whatever the picture's noise: what is noisier cannot be told from texture. 2.9 sigma of one pixel,
// where a dot of 2.6 px has ten of them.
constexpr double kMostResidual = 0.35;
constexpr double kRounding_lsb2 = 1.0 / 12;  // of a picture without noise: whole grey levels
// Of the contrast, by how many dots the pose rests on: what light may leave that no model has, shadows' edges first.
// Nine dots in their places are no chance; six may be. Over 1400 rendered pictures true poses left 0.09 with six dots
// and less, 0.23 with nine across stripes of shade; poses of a wrong start 4 to 10 times the noise with six dots and
// less, and look-alikes in photographs an eighth of the contrast at least.
constexpr std::array<double, kDotCount + 1> kFitContrast{0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.03, 0.06, 0.08, 0.10};

// Of a dot's radius: how far the outlines of a print may lie from where they should, root mean square. Bumpy sheets
// leave up to 0.03. With half of the dots a wrong pose follows all but a print's flatness: 26 such poses (50 % hidden)
// lay off by 0.06 to 0.23 px, true ones by 0.004 to 0.04 px in nine of ten.
constexpr double kPrintMisfit = 0.05, kPrintMisfit_px = 0.03;
// Where a dot or two are hidden, which what lies elsewhere may be taken for. Rendered ones left 0.006.
constexpr double kPartialMisfit = 0.02;
// The same of dots whose shape nobody can tell: flat sheets leave that.
constexpr double kShapelessMisfit = 0.02;
// Of more dots beside that, in shares of a blur that is wide (kBlurThatHides) or longer one way: no lens and no
// motion blurs as a Gaussian does. Discs of confusion of 3 px leave 0.08 of a dot of 3 px, motion by 8 px 0.12.
constexpr double kBlurMisfit = 0.2, kMotionMisfit = 0.15;
constexpr double kFewDotsMisfit = 0.002;  // of a dot's radius, beside kPrintMisfit_px
constexpr double kNoiseMisfit_px = 0.8;   // times residual over contrast: an outline's shift by noise
// Common offset of all outlines, in sigmas of the blur: sRGB moves a blurred edge inwards by 0.46 of them, whatever the
// blur (0.5 to 1.9 px, rendered), sharpening by 0.8, a steep tone curve or clipped paper by 1.3; more is another size
// of dots. Nothing that a camera does moves them outwards, and what print and paper add to ink is a share of the
// radius.
constexpr double kMostInwards = 1.2, kMostOutwards = 0.15, kMostOffset_px = 0.1, kDotGain = 0.02;
// Of small dots, whose outlines are nearly all blur, that allows for dots larger by a fifth. Rendered landmarks lie a
// fiftieth of the radius further out at most, in linear light as well, holes of grilles that passed for them 0.1 to
// 0.18; beside it what the pixels leave open.
constexpr double kLargerDots = 0.07, kOffsetSigmas = 2;
// How far outlines may lie from discs', in the shares of outline_shape.h. Over 1500 rendered pictures true landmarks
// had 0.04 at most (size), 0.04 (second), 0.026 (fourth) and 0.1 (P9 aside, warped sheets). A square has 0.11 (fourth),
// an ellipse of 0.6 to 1 has 0.26 (second), dots of growing size 0.1.
constexpr double kMostSize = 0.05, kMostSecond = 0.12, kMostFourth = 0.04, kMostAside = 0.2;
// P9's size against the ring's dots': 0.024 at most where nothing moved; of a middle that is larger by half 0.3.
constexpr double kMostCentreSize = 0.1;
constexpr double kColouredSize = 0.04;  // beside kMostSize
// How dark P9 is beside the ring's dots: 0.91 to 1.18 in 1400 rendered pictures, the extremes in dots of 2 px and under
// effects; where holes of a grille were taken for dots 0.76 and 0.82. P9 is black whatever the colours about it, and
// what covers the ring leaves it as dark: of 2200 fits in rooms of coloured sheets none had less than 1, of partly
// covered ones 0.96; bolts about a hub, partly covered, had 0.85.
constexpr double kLeastCentreInk = 0.87;
// Motion by 2 to 10 px leaves up to 0.29 (second) and 0.31 (P9's size) of dots of 3 to 4 px (120 rendered pictures):
// less than so much beside the limits above, in shares of the blur's second harmonic; of P9's size only as far as the
// blur is wider than a sharp one as well. Lenses out of focus leave P9 as it is, to 0.03.
constexpr double kPerAlong = 3, kSharp_px2 = 0.9, kCentrePerBlur = 2;
// Four corners are blurred away first: of dots of two sigmas what a profile that is no Gaussian leaves of the contrast
// (1 % of it, drawn dots of 4.6 px) looks like 0.1 of them, which is what a square of that size has. From three on they
// can be told.
constexpr double kFourthPerBlur = 0.55, kBlurThatHides = 0.1;
// Sum of the squares of what the outlines are off and of what their shapes are, each in shares of its limit: what is
// off in every way a little is another thing. Of 2700 fits of rendered landmarks the worst had 1.27, of eight behind
// bumpy plastic one 1.7; bolts about a hub had 1.6.
constexpr double kMostTogether = 1.3;
// Sharpening by 150 % leaves -1 where dots are small; blur that is too wide by far asks for ink darker than black.
constexpr double kDarkestInk_lsb = -10;
// Of P9's outline. A straight edge that leaves five ring dots leaves two thirds of P9's outline, one that leaves four a
// quarter: half of that, for the dots beside the edge count as whole when they are not quite.
constexpr double kCentreBesideFive = 0.33, kCentreBesideFour = 0.12;
constexpr int kLeastSpots = 3;          // on blank paper: two may be dirt
constexpr double kWholeDot = 0.9;       // visible share: the dot counts as whole
constexpr double kMostOfCentre = 0.75;  // of P9's outline: where it shows less, dots around it show no more

double square(double x) noexcept { return x * x; }

/// The blur's second harmonic, of a dot's radius squared: motion.
double along_of(const PoseCandidate& candidate) noexcept {
  return std::hypot(candidate.outlines.blur_cos_px2, candidate.outlines.blur_sin_px2) / square(candidate.dot_radius_px);
}

/// By how much the blur is wider than one that leaves dots of such a radius squared their form, in shares of that.
double wide_of(const PoseCandidate& candidate, double radius2_px2) noexcept {
  return std::max(candidate.outlines.blur_px2 / radius2_px2 - kBlurThatHides, 0.0);
}

/// How far the outlines of a print may lie from where they should, root mean square [px].
double most_misfit_px(const PoseCandidate& candidate, int dots, double noise_lsb) noexcept {
  const double radius_px = candidate.dot_radius_px;
  const OutlineFit& fit = candidate.fit;
  if (dots <= kFewDots)
    return kFewDotsMisfit * radius_px + kPrintMisfit_px + kNoiseMisfit_px * fit.residual_lsb / fit.contrast_lsb;
  const double by_blur_px =
      (kBlurMisfit * wide_of(candidate, square(radius_px)) + kMotionMisfit * along_of(candidate)) * radius_px;
  if (candidate.shape.is_unknown)
    return kShapelessMisfit * radius_px + kPrintMisfit_px + by_blur_px + kNoiseMisfit_px * noise_lsb / fit.contrast_lsb;
  const double of_print = dots == static_cast<int>(kDotCount) ? kPrintMisfit : kPartialMisfit;
  return of_print * radius_px + kPrintMisfit_px + by_blur_px;
}

/// Discs of the landmark's sizes, and none printed elsewhere.
/// \param misfit_share  root mean square of what their outlines are off, in shares of the most that it may be
/// \param inwards_share  how far they lie inwards, likewise
bool are_discs(const PoseCandidate& candidate, bool is_coloured, double misfit_share, double inwards_share) noexcept {
  const OutlineShape& shape = candidate.shape;
  if (shape.absent != 0 || shape.hollow != 0 || shape.spots >= kLeastSpots) return false;
  if (shape.centre_ink < kLeastCentreInk) return false;
  // Motion makes all dots longer in one direction; ellipses that lie in several look blurred alike.
  const double along = along_of(candidate);
  const auto most_fourth = [&](double radius_px) {
    const double semi_axes_px2 = square(radius_px) * foreshortening(candidate.outlines.T_camera_landmark);
    return kMostFourth + kFourthPerBlur * wide_of(candidate, semi_axes_px2);
  };
  InlineVector<double, 8> shares;  // of what each may be
  const auto add = [&](double amount, double most) { (void)shares.try_push_back(amount / most); };
  add(misfit_share, 1);
  // Of dots whose shape nobody can tell their size is all that is left: rings of another radius have another one.
  if (shape.is_unknown) add(inwards_share, 1);
  add(shape.size, kMostSize + (is_coloured ? kColouredSize : 0));
  add(shape.second, kMostSecond + kPerAlong * along);
  add(shape.fourth, most_fourth(candidate.dot_radius_px));
  if (has_whole_ring(candidate)) {
    add(shape.centre, kMostAside);
    const double wider = std::max(candidate.outlines.blur_px2 - kSharp_px2, 0.0) / square(candidate.dot_radius_px);
    if (!is_coloured) add(shape.centre_size, kMostCentreSize + kCentrePerBlur * std::min(along, wider));
    if (candidate.visible_share[kCentreDot] >= kWholeDot)
      add(shape.centre_fourth, most_fourth(candidate.centre_radius_px));
  }
  double together = 0;
  for (const double share : shares) together += share * share;
  return std::ranges::all_of(shares, [](double share) { return share <= 1; }) && together <= kMostTogether;
}

/// What hides a landmark comes from outside: it hides P9 after dots of the ring, and neighbours together.
bool is_plausibly_hidden(const std::array<double, kDotCount>& visible) noexcept {
  int whole = 0, holes = 0;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
    whole += visible[dot] >= kWholeDot;
    holes += visible[dot] < kMinVisible && visible[(dot + 1) % kRingDotCount] >= kWholeDot &&
             visible[(dot + 7) % kRingDotCount] >= kWholeDot;
  }
  const double centre = visible[kCentreDot];
  const double least_of_ring = *std::min_element(visible.begin(), visible.begin() + kRingDotCount);
  if (centre < kMostOfCentre && centre < least_of_ring) return false;
  return holes <= 1 && centre >= (whole >= 5 ? kCentreBesideFive : whole == 4 ? kCentreBesideFour : 0);
}

/// From (rotation about the landmark's origin, translation) of the sheet before the camera to (position of the camera
/// in S0, rotation vector in the camera frame): dc = R_lc (dw x t - dt), w = -dw.
/// \param of_step  of (rotation [rad], translation [m])
Matrix6d covariance_of(const CameraFromLandmark& T, const Matrix6d& of_step, const DotSightings& dots,
                       const CameraModel& camera, const LandmarkGeometry& landmark) noexcept {
  const Eigen::Vector3d& t = T.translation_m;
  Eigen::Matrix3d t_cross;
  t_cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix6d M = Matrix6d::Zero();
  M.topLeftCorner<3, 3>() = -T.rotation.transpose() * t_cross;
  M.topRightCorner<3, 3>() = -T.rotation.transpose();
  M.bottomLeftCorner<3, 3>() = -Eigen::Matrix3d::Identity();
  Matrix6d covariance = M * covariance_over_tilts(T, dots, landmark, of_step) * M.transpose();
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  covariance.bottomRightCorner<3, 3>().diagonal().array() += std::pow(kCommonShift_px / camera.fx_px, 2);
  return covariance;
}

Matrix6d covariance_of_step(const UnknownMatrix& all) noexcept {
  Matrix6d of_step = all.topLeftCorner<kPoseUnknowns, kPoseUnknowns>();
  of_step.topRows<3>() /= kLever_m;
  of_step.leftCols<3>() /= kLever_m;
  return of_step;
}

/// 0 nothing hidden, I..III of the founding paper as 1..3.
int occlusion_level(const std::array<double, kDotCount>& visible) noexcept {
  if (visible[kCentreDot] < kHalf) return 3;
  const auto hidden =
      std::count_if(visible.begin(), visible.begin() + kRingDotCount, [](double v) { return v < kHalf; });
  return hidden > 2 ? 2 : hidden > 0 ? 1 : 0;
}

}  // namespace

PoseCandidate candidate_of(const OutlineRefiner& refiner, const CameraModel& camera,
                           const LandmarkGeometry& landmark) noexcept {
  PoseCandidate candidate;
  candidate.outlines = refiner.state();
  candidate.statistics = refiner.statistics();
  candidate.fit = refiner.fit();
  candidate.dot_radius_px = refiner.dot_radius_px();
  candidate.centre_radius_px = candidate.dot_radius_px * landmark.centre_radius_m / landmark.dot_radius_m;
  candidate.visible_share = refiner.visible_share();
  candidate.dots = refiner.dots();
  PoseEstimate& pose = candidate.pose;
  pose.T_landmark_camera = refiner.state().T_camera_landmark.inverse();
  pose.rms_px = refiner.rms_px();
  pose.ellipse = ellipse_parameters(pose.T_landmark_camera, camera, landmark);
  const UnknownMatrix covariance = inverse_of_definite(refiner.information());
  candidate.offset_sigma_px = std::sqrt(covariance(kPoseUnknowns, kPoseUnknowns));
  pose.covariance = covariance_of(refiner.state().T_camera_landmark, covariance_of_step(covariance), candidate.dots,
                                  camera, landmark);
  const auto& visible = candidate.visible_share;
  pose.dots_used = dots_in_sight(visible);
  pose.occlusion_level = occlusion_level(visible);
  return candidate;
}

PoseCandidate candidate_of(const PoseOfPlaces& other, const PoseCandidate& seen, const CameraModel& camera,
                           const LandmarkGeometry& landmark) noexcept {
  PoseCandidate candidate = seen;
  candidate.outlines.T_camera_landmark = other.T_camera_landmark;
  candidate.pose.T_landmark_camera = other.T_camera_landmark.inverse();
  candidate.pose.ellipse = ellipse_parameters(candidate.pose.T_landmark_camera, camera, landmark);
  candidate.pose.covariance = covariance_of(other.T_camera_landmark, other.covariance, seen.dots, camera, landmark);
  return candidate;
}

int dots_in_sight(const std::array<double, kDotCount>& visible_share) noexcept {
  return static_cast<int>(std::ranges::count_if(visible_share, [](double share) { return share >= kMinVisible; }));
}

bool has_whole_ring(const PoseCandidate& candidate) noexcept {
  const auto& visible = candidate.visible_share;
  return std::all_of(visible.begin(), visible.begin() + kRingDotCount, [](double share) { return share >= kWholeDot; });
}

bool fits_picture(const PoseCandidate& candidate, const PictureNoise& noise, const FitAllowance& allowance) noexcept {
  const OutlineFit& fit = candidate.fit;
  const double of_paper = noise.at(fit.paper_lsb), of_ink = noise.at(fit.paper_lsb - fit.contrast_lsb);
  const double noise_lsb2 = 0.5 * (of_paper * of_paper + of_ink * of_ink) + kRounding_lsb2;
  const int dots = std::clamp<int>(candidate.pose.dots_used, 0, kDotCount);
  // Nine dots in their places are no chance; nine places of what nobody can tell the shape of may be.
  const auto told = static_cast<std::size_t>(candidate.shape.is_unknown ? 0 : dots);
  const double light_lsb = kFitContrast[told] * fit.contrast_lsb;
  if (candidate.shape.is_unknown && dots <= kFewDots) return false;
  const double misfit_share =
      candidate.pose.rms_px / (most_misfit_px(candidate, dots, std::sqrt(noise_lsb2)) + allowance.misfit_px);
  const double blur_px = std::sqrt(std::max(candidate.outlines.blur_px2, 0.0));
  const double offset_px = candidate.outlines.offset_px;
  const double inwards_share = -offset_px / (kMostInwards * blur_px + kMostOffset_px);
  if (!(inwards_share <= 1)) return false;
  const double radius_px = candidate.dot_radius_px;
  if (!(offset_px <= kMostOutwards * blur_px + kMostOffset_px + kDotGain * radius_px)) return false;
  if (!(offset_px <= kLargerDots * radius_px + kOffsetSigmas * candidate.offset_sigma_px)) return false;
  if (!(fit.paper_lsb - fit.contrast_lsb >= kDarkestInk_lsb)) return false;
  if (!is_plausibly_hidden(candidate.visible_share)) return false;
  if (!are_discs(candidate, allowance.is_coloured, misfit_share, std::max(inwards_share, 0.0))) return false;
  return fit.residual_lsb <= kMostResidual * fit.contrast_lsb &&
         fit.residual_lsb * fit.residual_lsb <= kFitNoise * kFitNoise * noise_lsb2 + light_lsb * light_lsb;
}

Result<void> check_pose(const PoseEstimate& pose, const CameraModel& camera, const LandmarkGeometry& landmark,
                        double most_sigma) noexcept {
  const double distance_m = pose.T_landmark_camera.translation_m.norm();
  if (pose.rms_px > kMaxMisfit * camera.fx_px * landmark.dot_radius_m / distance_m)
    return fail(Errc::kNoLandmark, "the outlines do not lie where those of one landmark would");
  const double sigma_m = std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace());
  if (!(sigma_m < most_sigma * distance_m) || pose.dots_used < kLeastDots)
    return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  return {};
}

}  // namespace ninedot
