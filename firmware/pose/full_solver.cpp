#include "pose/full_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/planar_pose.h"
#include "pose/ellipse_parameters.h"
#include "pose/outline_model.h"

// Start from the dots' centroids (both planar solutions), then Gauss-Newton on the grey levels along all outlines.
// Groups whose outline is not where the others say, or that show no outline at all (hidden, cut by a shadow), lose
// their weight (iteratively reweighted least squares; Geman & McClure's weight). The step's normal matrix is the
// information matrix.

namespace ninedot {
namespace {

constexpr std::size_t kMaxPixels = 12000;
constexpr int kMaxIterations = 7;
constexpr int kLastCollection = 2;     // iterations after it keep their pixels, unless a dot is split
constexpr int kFirstThinning = 2;      // of the pixels, while the pose is off by tenths of a pixel
constexpr double kFirstBand_px = 3.5;  // the centroids' start is good to a pixel
constexpr double kBandPerSigma = 2.6;  // beyond, an outline's grey levels no longer depend on its place
constexpr double kOffsetSigma_px =
    0.35;  // prior of the common offset: an sRGB curve moves edges by 0.3 px (METHOD, section 3)
constexpr double kHarmonicSigma_px2 = 0.6;  // prior of the blur's direction
constexpr double kMeanBlur_px2 = 0.7, kMeanBlurSigma_px2 = 3;
constexpr double kCentroidSigma_px =
    0.15;                                 // of a blob, at best, for telling the two planar solutions apart at a glance
constexpr std::size_t kMinCentroids = 5;  // for a start from centroids
constexpr double kDecisive = 60;          // difference of chi^2 above which the other solution is not even refined
constexpr double kSamePose_rad = 0.005;   // two solutions closer than this are one
constexpr double kMinGroupShare = 0.3;    // of a dot's groups, to count it as used

struct Refined {
  OutlineState state;
  UnknownMatrix information = UnknownMatrix::Zero();
  double noise_variance = 1;      // LSB^2
  double model_variance_px2 = 0;  // of the groups' places, beyond the noise
  double rms_px = 0;
  std::array<double, kMaxGroups> weight{};       // in the normal equations
  std::array<bool, kMaxGroups> outline_there{};  // an outline where it belongs, though its light may be spoiled
  bool converged = false;
};

/// The value that `share` of the values lie below; reorders them.
double quantile(std::span<double> values, double share) noexcept {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

struct FullSolver::Workspace {
  Workspace(const CameraModel& camera_model, const LandmarkGeometry& landmark_geometry)
      : camera(camera_model), landmark(landmark_geometry), rays(camera_model), pixels(kMaxPixels) {}

  Result<PlanarPoses> start_from_centroids(const LandmarkObservation& seen) const noexcept;
  bool refine(const ImageView& luma, CameraFromLandmark start, Refined& out) noexcept;
  void fit_all(const OutlineState& state) noexcept;
  void weigh_groups(int iteration, Refined& out) noexcept;
  double model_variance(double noise_variance, double contrast_lsb) const noexcept;
  bool split_shadowed_dots(double noise_variance) noexcept;
  double difference_of_chi2(const Refined& best, const Refined& other) noexcept;
  PoseEstimate conclude(const Refined& best, double ambiguity) const noexcept;

  CameraModel camera;
  LandmarkGeometry landmark;
  RayTable rays;
  OutlinePixels pixels;
  std::array<GroupFit, kMaxGroups> fits;
  std::array<bool, kDotCount> split{};  ///< dots whose light is not smooth: cut into sectors although they are small
};

Result<PlanarPoses> FullSolver::Workspace::start_from_centroids(const LandmarkObservation& seen) const noexcept {
  InlineVector<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!seen.dots[dot].seen) continue;
    const auto ray = camera.normalised_from_pixel(seen.dots[dot].centroid_px);
    if (ray) (void)points.try_push_back({landmark.centre_m(dot), *ray});
  }
  if (points.size() >= kMinCentroids) return solve_planar_pose(points.span());
  // Four dots may lie three on a line; the detector's map of the sheet is as good and covers all nine places.
  points.clear();
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = landmark.centre_m(dot);
    const Eigen::Vector3d q = seen.H_ray_plane * Eigen::Vector3d(C.x(), C.y(), 1);
    (void)points.try_push_back({C, q.hnormalized()});
  }
  return solve_planar_pose(points.span());
}

void FullSolver::Workspace::fit_all(const OutlineState& state) noexcept {
  for (std::size_t i = 0; i < pixels.groups.size(); ++i)
    fit_group(pixels, pixels.groups[i], landmark, state, true, fits[i]);
}

/// Weights of all groups from their contrast, their residuals and their shift against what the state says.
void FullSolver::Workspace::weigh_groups(int iteration, Refined& out) noexcept {
  constexpr double kMinContrastShare = 0.3;
  constexpr double kMinContrast_lsb = 4;
  constexpr double kNoiseQuantile = 0.35;
  // While the pose is still off by pixels every group is shifted, and none is an outlier.
  const double shift_floor_px = iteration == 0 ? 1.5 : iteration == 1 ? 0.6 : 0.12;
  std::array<double, kMaxGroups> contrasts, papers, variances;
  std::size_t count = 0;
  for (std::size_t i = 0; i < pixels.groups.size(); ++i) {
    const GroupFit& fit = fits[i];
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
  out.noise_variance = std::max(quantile(std::span(variances).first(count), kNoiseQuantile), 1.0 / 12);

  out.model_variance_px2 = model_variance(out.noise_variance, contrast_lsb);
  double sum_weight = 0, sum_shift = 0;
  for (std::size_t i = 0; i < pixels.groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    double& weight = out.weight[i];
    weight = 0;
    out.outline_there[i] = false;
    if (!fit.usable) continue;
    const double light = std::clamp(fit.paper_lsb / std::max(paper_lsb, 1.0), 0.25, 1.5);
    if (fit.contrast_lsb < std::max(kMinContrast_lsb, kMinContrastShare * contrast_lsb * light)) continue;
    const double variance = fit.squared_residuals / fit.degrees_of_freedom;
    const double allowed = 3 * out.noise_variance + std::pow(0.02 * fit.contrast_lsb, 2);
    const double expected_px2 = out.noise_variance / fit.shift_information;
    const double u2 =
        fit.shift_px * fit.shift_px / (9 * (expected_px2 + out.model_variance_px2 + shift_floor_px * shift_floor_px));
    double trust = 1 / ((1 + u2) * (1 + u2));
    const double misfit = std::max(variance / allowed, 1.0);
    out.outline_there[i] = trust / std::max(misfit * misfit / 64, 1.0) > 0.25;
    trust /= misfit * misfit;
    sum_weight += trust;
    sum_shift += trust * fit.shift_px * fit.shift_px;
    weight = trust / (1 + out.model_variance_px2 / expected_px2);
  }
  out.rms_px = sum_weight > 0 ? std::sqrt(sum_shift / sum_weight) : 0;
}

/// Variance of the groups' places about the model's beyond what noise explains: warped sheets, shadows, the model's own
/// faults. DerSimonian & Laird, "Meta-analysis in clinical trials", Controlled Clinical Trials 7 (1986): the excess of
/// the weighted squares over their expectation. A group is moved along and across and grown (whole dots), or shifted.
double FullSolver::Workspace::model_variance(double noise_variance, double contrast_lsb) const noexcept {
  constexpr double kOutlier = 16;  // times the median chi^2 per degree of freedom
  struct Displaced {
    double chi2, information;
    int freedom;
  };
  InlineVector<Displaced, kMaxGroups> groups;
  std::array<double, kMaxGroups> per_freedom;
  for (std::size_t i = 0; i < pixels.groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    if (!fit.usable || fit.contrast_lsb < 0.3 * contrast_lsb) continue;
    Displaced d{fit.shift_px * fit.shift_px * fit.shift_information / noise_variance,
                fit.shift_information / noise_variance, 1};
    if (pixels.groups[i].whole_dot) {
      constexpr std::array<Eigen::Index, 3> kMoves{3, 4, 6};  // translation along the picture's axes, growth
      const Eigen::Matrix3d N = fit.normal(kMoves, kMoves);
      const Eigen::Vector3d g = fit.gradient(kMoves);
      d = {g.dot(N.ldlt().solve(g)) / noise_variance, d.information, 3};
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
bool FullSolver::Workspace::split_shadowed_dots(double noise_variance) noexcept {
  constexpr double kMaxVariance = 2.5;  // of the noise; smooth light gives 0.7 .. 1.6
  constexpr double kMaxMisfit = 0.02;   // of the contrast: what the outline's model itself leaves over
  bool any = false;
  for (std::size_t i = 0; i < pixels.groups.size(); ++i) {
    const GroupFit& fit = fits[i];
    if (!pixels.groups[i].whole_dot || !fit.usable) continue;
    const double variance = fit.squared_residuals / fit.degrees_of_freedom;
    if (variance > kMaxVariance * noise_variance + std::pow(kMaxMisfit * fit.contrast_lsb, 2)) {
      any = any || !split[pixels.groups[i].dot];
      split[pixels.groups[i].dot] = true;
    }
  }
  return any;
}

bool FullSolver::Workspace::refine(const ImageView& luma, CameraFromLandmark start, Refined& out) noexcept {
  out.state = OutlineState{};
  out.state.T_camera_landmark = start;
  out.converged = false;
  double band_px = kFirstBand_px;
  bool just_split = false;
  split.fill(false);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (iteration <= kLastCollection || just_split) {
      collect_outline_pixels(luma, camera, rays, landmark, out.state.T_camera_landmark, band_px,
                             iteration == 0 ? kFirstThinning : 1, split, pixels);
      if (pixels.groups.empty()) return false;
    }
    fit_all(out.state);
    weigh_groups(iteration, out);
    just_split = iteration >= 1 && iteration <= 3 && split_shadowed_dots(out.noise_variance);

    UnknownMatrix A = UnknownMatrix::Zero();
    UnknownVector b = UnknownVector::Zero();
    for (std::size_t i = 0; i < pixels.groups.size(); ++i) {
      if (out.weight[i] <= 0) continue;
      A += out.weight[i] * fits[i].normal;
      b += out.weight[i] * fits[i].gradient;
    }
    A /= out.noise_variance;
    b /= out.noise_variance;
    const auto prior = [&](int unknown, double value, double mean, double sigma) {
      A(unknown, unknown) += 1 / (sigma * sigma);
      b(unknown) += (mean - value) / (sigma * sigma);
    };
    prior(6, out.state.offset_px, 0, kOffsetSigma_px);
    prior(7, out.state.blur_px2, kMeanBlur_px2, kMeanBlurSigma_px2);
    prior(8, out.state.blur_cos_px2, 0, kHarmonicSigma_px2);
    prior(9, out.state.blur_sin_px2, 0, kHarmonicSigma_px2);
    const Eigen::LDLT<UnknownMatrix> ldlt(A);
    if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return false;
    const UnknownVector step = ldlt.solve(b);
    if (!step.allFinite()) return false;
    out.information = A;
    out.state.apply(step);
    if (!(out.state.T_camera_landmark.translation_m.z() > 0)) return false;
    const double sigma_px = std::sqrt(out.state.blur_px2 + std::hypot(out.state.blur_cos_px2, out.state.blur_sin_px2));
    band_px = std::clamp(kBandPerSigma * sigma_px + 0.3, 1.8, 8.0);
    // A step of the pose of a sixth of a standard deviation changes nothing that can be seen.
    const Vector6d moved = step.head<6>();
    if (iteration >= kLastCollection && !just_split && moved.dot(A.topLeftCorner<6, 6>() * moved) < 0.03) {
      out.converged = true;
      break;
    }
  }
  return true;
}

/// How much worse `other` explains the pixels that `best` was fitted to, in units of the noise.
double FullSolver::Workspace::difference_of_chi2(const Refined& best, const Refined& other) noexcept {
  double difference = 0;
  GroupFit fit;
  for (std::size_t i = 0; i < pixels.groups.size(); ++i) {
    if (best.weight[i] <= 0) continue;
    fit_group(pixels, pixels.groups[i], landmark, other.state, false, fit);
    GroupFit own;
    fit_group(pixels, pixels.groups[i], landmark, best.state, false, own);
    difference += best.weight[i] * (fit.squared_residuals - own.squared_residuals) / best.noise_variance;
  }
  return difference;
}

PoseEstimate FullSolver::Workspace::conclude(const Refined& best, double ambiguity) const noexcept {
  PoseEstimate pose;
  const CameraFromLandmark& T = best.state.T_camera_landmark;
  pose.T_landmark_camera = T.inverse();
  pose.ambiguity = ambiguity;
  pose.rms_px = best.rms_px;
  pose.ellipse = ellipse_parameters(pose.T_landmark_camera, camera, landmark);

  // From (rotation about the landmark's origin, translation) of the sheet before the camera to (position of the camera
  // in S0, rotation vector in the camera frame): dc = R_lc (dw x t - dt), w = -dw.
  const Eigen::Matrix3d R = pose.T_landmark_camera.rotation;
  const Eigen::Vector3d t = T.translation_m;
  Eigen::Matrix3d t_cross;
  t_cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix6d M = Matrix6d::Zero();
  M.topLeftCorner<3, 3>() = -R * t_cross / kLever_m;
  M.topRightCorner<3, 3>() = -R;
  M.bottomLeftCorner<3, 3>() = -Eigen::Matrix3d::Identity() / kLever_m;
  const UnknownMatrix all = best.information.inverse();
  pose.covariance = M * all.topLeftCorner<6, 6>() * M.transpose();
  pose.covariance = 0.5 * (pose.covariance + pose.covariance.transpose()).eval();

  std::array<int, kDotCount> groups{}, good{};
  for (std::size_t i = 0; i < pixels.groups.size(); ++i) {
    ++groups[pixels.groups[i].dot];
    good[pixels.groups[i].dot] += best.outline_there[i];
  }
  int ring_missing = 0;
  bool centre_missing = false;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const double share = groups[dot] > 0 ? static_cast<double>(good[dot]) / groups[dot] : 0;
    pose.dots_used += share >= kMinGroupShare;
    if (share >= 0.5) continue;
    if (dot == kCentreDot)
      centre_missing = true;
    else
      ++ring_missing;
  }
  pose.occlusion_level = centre_missing ? 3 : ring_missing > 2 ? 2 : ring_missing > 0 ? 1 : 0;
  return pose;
}

FullSolver::FullSolver(const CameraModel& camera, const LandmarkGeometry& landmark)
    : workspace_(std::make_unique<Workspace>(camera, landmark)) {}

FullSolver::~FullSolver() = default;

Result<PoseEstimate> FullSolver::solve(const ImageView& luma, const LandmarkObservation& seen,
                                       const Transform<frame::Landmark, frame::Camera>* previous) noexcept {
  Workspace& w = *workspace_;
  NINEDOT_TRY(const PlanarPoses starts, w.start_from_centroids(seen));
  const double sigma_px = std::max(kCentroidSigma_px, starts[0].rms * w.camera.fx_px);
  const double scale = w.camera.fx_px / sigma_px;
  // A start from the detector's map fits itself: its residuals say nothing.
  const bool from_centroids = seen.seen_count >= static_cast<int>(kMinCentroids);
  const double coarse = from_centroids ? 2 * std::max(seen.seen_count, 4) *
                                             (std::pow(starts[1].rms * scale, 2) - std::pow(starts[0].rms * scale, 2))
                                       : 0;
  const auto angle_between = [](const CameraFromLandmark& a, const CameraFromLandmark& b) {
    return log_so3(a.rotation.transpose() * b.rotation).norm();
  };
  const bool one_minimum = angle_between(starts[0].T_camera_landmark, starts[1].T_camera_landmark) < kSamePose_rad;
  const bool try_both = !one_minimum && coarse < kDecisive;

  Refined first, second;
  bool first_ok = w.refine(luma, starts[0].T_camera_landmark, first);
  double ambiguity = one_minimum ? 0 : std::exp(-0.5 * std::max(coarse, 0.0));
  if (try_both) {
    const bool second_ok = w.refine(luma, starts[1].T_camera_landmark, second);
    if (second_ok && !first_ok) {
      first = second, first_ok = true;
      ambiguity = 0;
    } else if (second_ok && first_ok) {
      // The pixels at hand are those of `second`.
      double worse_by = w.difference_of_chi2(second, first);
      const bool same = angle_between(first.state.T_camera_landmark, second.state.T_camera_landmark) < kSamePose_rad;
      bool second_wins = worse_by > 0;
      // Where the picture can't tell (3 sigma), the track may.
      if (previous != nullptr && std::abs(worse_by) < 9) {
        const auto turn = [&](const Refined& r) {
          return log_so3(previous->rotation * r.state.T_camera_landmark.rotation).norm();
        };
        second_wins = turn(second) < turn(first);
      }
      ambiguity = same ? 0 : std::exp(-0.5 * std::abs(worse_by));
      if (second_wins) {
        first = second;
      } else {
        // Weights and groups must belong together when the result is concluded.
        first_ok = w.refine(luma, first.state.T_camera_landmark, first);
      }
    }
  }
  if (!first_ok) return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  PoseEstimate pose = w.conclude(first, std::min(ambiguity, 1.0));
  if (!pose.covariance.allFinite() || pose.dots_used < 3)
    return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  return pose;
}

}  // namespace ninedot
