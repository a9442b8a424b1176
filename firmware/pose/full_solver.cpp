#include "pose/full_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/planar_pose.h"
#include "pose/mirror_image.h"
#include "pose/outline_refiner.h"
#include "pose/pose_of_outlines.h"

// Start from the dots' centroids (both planar solutions), refine along the outlines the one that fits better, look at
// its mirror image, and refine that too unless the grey levels, or the centroids before them, exclude it.

namespace ninedot {
namespace {

// Of a blob's centroid, at best, for telling the two planar solutions apart at a glance: a thresholded centroid of 3 px
// (METHOD, section 3), rounded up.
constexpr double kCentroidSigma_px = 0.15;
// For a start from centroids: four points determine a homography exactly, and may lie three on a line.
constexpr std::size_t kLeastCentroids = 5;
// Difference of chi^2 above which the other solution is not even refined: a refinement gains less than that over a
// glance with the best one's pixels (7.7 sigma; the model's own faults included).
constexpr double kDecisive_chi2 = 60;
// The same where a track has told the two apart: odds of 1 to 10000, while they are further apart than a track's noise.
constexpr double kSettled_chi2 = 18.4, kApart_rad = 0.17;
// Places that say the opposite of the grey levels by more: the grey levels have something that the model has
// not, and the two poses stay open.
constexpr double kContradiction_chi2 = 4;
// Odds of exp(-500): how much further beyond makes no difference to anything.
constexpr double kBeyondDoubt_chi2 = 1000;
// Residual of centroids that a track may start from at once: its outlines then lie within the half pixel of
// Start::kClose.
constexpr double kCloseStart_px = 0.4;
// Edges of light cross a few dots. Where they seem to cross more, the outlines weren't where they were expected.
constexpr int kMostShadowed = 4;
// Of six freedoms: exceeded once in 5000 by what noise makes of the first pose, which the second one knows in part.
constexpr double kNearby_chi2 = 26;
// A tone curve that asks for ink so much darker than black is none: dots of 1.2 px did by 14 grey levels, a loudspeaker
// by 41.
constexpr double kDarkest_lsb = -20;
// Of a pose's residual: its mirror image that is still so much further from the picture after some steps will not
// become the better one, and takes no more of the pixels.
constexpr double kMuchWorse = 3;
// Of the centroids' residual: what of it may be the sheet's warp or a shadow's pull, the rest being noise.
constexpr double kWarpShare = 0.5;

/// From where to refine.
struct Starts {
  std::array<CameraFromLandmark, 2> side;  ///< both planar solutions, the better or the track's own first
  double rms_px = 0;                       ///< of the centroids against side[0]
  double second_chi2_above = 0;            ///< of the centroids against the worse one; 0 where they can't tell
  bool differ = false;                     ///< they are two
  bool centroids_decide() const noexcept { return differ && second_chi2_above >= kDecisive_chi2; }
};

bool is_better(const std::optional<PoseCandidate>& mirror) noexcept {
  return mirror && mirror->refined && mirror->chi2_above < 0;
}

/// The outlines as they were, as they are where the sheet moves so.
OutlineState start_of(OutlineState before, const CameraFromLandmark& T_camera_landmark, const SheetMotion& motion,
                      double focal_px) noexcept {
  UnknownVector step = UnknownVector::Zero();
  step.segment<3>(kPoseUnknowns + 1) -= smear_px2(before, focal_px);
  before.T_camera_landmark = T_camera_landmark;
  before.motion = motion;
  step.segment<3>(kPoseUnknowns + 1) += smear_px2(before, focal_px);
  before.apply(step);
  return before;
}

/// The better one first, with how much worse the other one fits. \return  the mirror image is the better one
bool list_by_fit(PoseCandidate best, std::optional<PoseCandidate> mirror, PoseCandidates& candidates) noexcept {
  const bool mirror_is_better = is_better(mirror);
  if (mirror && mirror->refined) {
    if (mirror_is_better) std::swap(best, *mirror);
    mirror->chi2_above = std::abs(mirror->chi2_above) + std::abs(best.chi2_above);
    best.chi2_above = 0;
  }
  (void)candidates.list.try_push_back(best);
  if (mirror) (void)candidates.list.try_push_back(*mirror);
  return mirror_is_better;
}

/// Whether the second pose lies where the first one says that the truth may be.
bool is_nearby(const PoseEstimate& first, const PoseEstimate& second) noexcept {
  Vector6d apart;
  apart << second.T_landmark_camera.translation_m - first.T_landmark_camera.translation_m,
      log_so3(first.T_landmark_camera.rotation.transpose() * second.T_landmark_camera.rotation);
  return apart.dot(first.covariance.ldlt().solve(apart)) < kNearby_chi2;
}

/// What a track has settled says nothing for a pose that has left its side.
bool is_on_settled_side(const PosePrior& prior, const CameraFromLandmark& own,
                        const CameraFromLandmark& mirrored) noexcept {
  const auto from_track_rad = [&](const CameraFromLandmark& T) {
    return angle_between_rad(prior.T_camera_landmark, T);
  };
  return prior.side_is_settled && from_track_rad(own) < from_track_rad(mirrored);
}

}  // namespace

struct FullSolver::Workspace {
  Workspace(const CameraModel& camera_model, const LandmarkGeometry& landmark_geometry,
            const FullSolverOptions& solver_options)
      : camera(camera_model),
        landmark(landmark_geometry),
        options(solver_options),
        rays(camera_model),
        first(std::make_unique<OutlineRefiner>(camera, landmark, rays, options.regards_walls)),
        second(std::make_unique<OutlineRefiner>(camera, landmark, rays, options.regards_walls)),
        lit(camera, landmark, rays, options.regards_walls) {}

  Eigen::Vector2d ray_at_middle(const LandmarkObservation& seen, std::size_t dot, const Eigen::Vector2d& ray,
                                double row_px, const SheetMotion& motion) const noexcept;
  Result<PlanarPoses> planar_poses(const LandmarkObservation& seen, const SheetMotion& motion) const noexcept;
  Result<Starts> starts_from(const LandmarkObservation& seen, const PosePrior* prior,
                             const SheetMotion& motion) const noexcept;
  bool refine_first(const ImageView& luma, const LandmarkObservation& seen, const Starts& starts,
                    const PosePrior* prior, double warp_px, int& pixels, const SheetMotion& motion) noexcept;
  double preference(const OutlineRefiner& whose, const CameraFromLandmark& other) const noexcept;
  double believable(double chi2_above, const OutlineState& other) const noexcept;
  bool list_by_places(const PosePrior& prior, const PoseCandidate& believed, PoseCandidates& candidates) const noexcept;
  std::optional<PoseCandidate> weigh_mirror(const ImageView& luma, const PosePrior* prior, double warp_px,
                                            int& pixels) noexcept;
  void begin_with_mirror(const ImageView& luma, const PosePrior* prior, double warp_px, int& pixels,
                         PoseCandidate& best, std::optional<PoseCandidate>& mirror) noexcept;
  bool fit_light(const ImageView& luma, const OutlineRefiner& chosen, double warp_px, int& pixels,
                 PoseCandidate& candidate) noexcept;

  CameraModel camera;
  LandmarkGeometry landmark;
  FullSolverOptions options;
  RayTable rays;
  std::unique_ptr<OutlineRefiner> first, second;  ///< scratch: a pose, and its mirror image
  OutlineRefiner lit;                             ///< scratch: the better of them, with the light that it is in
  bool is_mirror_open = false;  ///< there were no pixels left to refine the last mirror image, which may be the better
};

/// Where a dot would have been seen while the middle row was exposed. The detector's map tells its depth well enough.
Eigen::Vector2d FullSolver::Workspace::ray_at_middle(const LandmarkObservation& seen, std::size_t dot,
                                                     const Eigen::Vector2d& ray, double row_px,
                                                     const SheetMotion& motion) const noexcept {
  if (motion.row_time_s == 0) return ray;
  const Eigen::Matrix3d sheet = depth_of_origin(seen.H_ray_plane) / seen.H_ray_plane(2, 2) * seen.H_ray_plane;
  const Eigen::Vector2d C = landmark.centre_m(dot);
  const Eigen::Vector3d p_m = sheet * C.homogeneous();
  if (!(p_m.z() > 0)) return ray;
  return ray - motion.since_s(row_px) * motion.ray_velocity(p_m, sheet.col(2));
}

Result<PlanarPoses> FullSolver::Workspace::planar_poses(const LandmarkObservation& seen,
                                                        const SheetMotion& motion) const noexcept {
  InlineVector<PlanePoint, kDotCount> points;  // as many as dots: no push can fail
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!seen.dots[dot].seen) continue;
    const auto ray = camera.normalised_from_pixel(seen.dots[dot].centroid_px);
    if (ray)
      (void)points.try_push_back(
          {landmark.centre_m(dot), ray_at_middle(seen, dot, *ray, seen.dots[dot].centroid_px.y(), motion)});
  }
  if (points.size() >= kLeastCentroids) return solve_planar_pose(points.span());
  // The detector's map of the sheet is as good and covers all nine places.
  points.clear();
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = landmark.centre_m(dot);
    const Eigen::Vector2d ray = (seen.H_ray_plane * C.homogeneous()).hnormalized();
    const double row_px = motion.row_time_s == 0 ? 0 : camera.pixel_from_normalised(ray).y();
    (void)points.try_push_back({C, ray_at_middle(seen, dot, ray, row_px, motion)});
  }
  return solve_planar_pose(points.span());
}

Result<Starts> FullSolver::Workspace::starts_from(const LandmarkObservation& seen, const PosePrior* prior,
                                                  const SheetMotion& motion) const noexcept {
  NINEDOT_TRY(PlanarPoses poses, planar_poses(seen, motion));
  Starts starts;
  const double apart_rad = angle_between_rad(poses[0].T_camera_landmark, poses[1].T_camera_landmark);
  starts.differ = apart_rad >= kSamePose_rad;
  // A start from the detector's map fits itself: its residuals say nothing.
  if (seen.seen_count >= static_cast<int>(kLeastCentroids)) {
    const double sigma_px = std::max(kCentroidSigma_px, poses[0].rms * camera.fx_px);
    const double scale = camera.fx_px / sigma_px;
    starts.second_chi2_above =
        2 * seen.seen_count * (std::pow(poses[1].rms * scale, 2) - std::pow(poses[0].rms * scale, 2));
  }
  // A track that has told the two solutions apart begins with the one that it is in.
  if (prior != nullptr && prior->side_is_settled && apart_rad > kApart_rad && !starts.centroids_decide()) {
    const auto turn_rad = [&](const PlanarPose& pose) {
      return angle_between_rad(prior->T_camera_landmark, pose.T_camera_landmark);
    };
    if (turn_rad(poses[1]) < turn_rad(poses[0])) std::swap(poses[0], poses[1]);
  }
  starts.side = {poses[0].T_camera_landmark, poses[1].T_camera_landmark};
  starts.rms_px = poses[0].rms * camera.fx_px;
  return starts;
}

/// The better start, or the other one where that one leads nowhere.
bool FullSolver::Workspace::refine_first(const ImageView& luma, const LandmarkObservation& seen, const Starts& starts,
                                         const PosePrior* prior, double warp_px, int& pixels,
                                         const SheetMotion& motion) noexcept {
  using Start = OutlineRefiner::Start;
  OutlineState start =
      start_of(prior != nullptr ? prior->outlines : OutlineState{}, starts.side[0], motion, camera.fx_px);
  const bool close =
      prior != nullptr && seen.seen_count >= static_cast<int>(kLeastCentroids) && starts.rms_px < kCloseStart_px;
  if (first->refine(luma, start, close ? Start::kClose : Start::kRough, warp_px, pixels).has_converged()) return true;
  if (!starts.differ || starts.centroids_decide()) return false;
  start.T_camera_landmark = starts.side[1];
  return first->refine(luma, start, Start::kRough, warp_px, pixels).has_converged();
}

/// By how much more chi^2 the dots' places, as one of the refiners has seen them, suit the first one's pose than the
/// other one. A blur that is even about its middle, whatever its shape, leaves places where they are.
double FullSolver::Workspace::preference(const OutlineRefiner& whose, const CameraFromLandmark& other) const noexcept {
  return preference_of_places(first->state().T_camera_landmark, other, whose.dots(), landmark);
}

/// Of what tells the first refiner's pose from another one, what their dots' places can carry.
double FullSolver::Workspace::believable(double chi2_above, const OutlineState& other) const noexcept {
  if (options.pattern_px == 0) return chi2_above;
  const double most_chi2 = evidence_of_places(first->state().T_camera_landmark, other.T_camera_landmark, first->dots(),
                                              options.pattern_px / camera.fx_px, landmark);
  return std::clamp(chi2_above, -most_chi2, most_chi2);
}

/// The readings without another look at the picture: of a side that is settled, where the dots' places are all that may
/// tell the two apart anyway. \return  false: it takes the picture to tell
bool FullSolver::Workspace::list_by_places(const PosePrior& prior, const PoseCandidate& believed,
                                           PoseCandidates& candidates) const noexcept {
  if (options.pattern_px == 0 || !prior.side_is_settled) return false;
  // What few dots say suits the pose that their weights are of.
  if (believed.pose.dots_used <= kFewDots) return false;
  const CameraFromLandmark own = believed.pose.T_landmark_camera.inverse();  // with its light, as its dots are
  const auto other = fit_to_places(believed.dots, landmark, reflected(own));
  if (!other) return false;
  std::optional<PoseCandidate> mirror;
  if (angle_between_rad(other->T_camera_landmark, own) >= kSamePose_rad) {
    if (!is_on_settled_side(prior, own, other->T_camera_landmark)) return false;
    mirror = candidate_of(*other, believed, camera, landmark);
    mirror->chi2_above =
        believable(preference_of_places(own, other->T_camera_landmark, believed.dots, landmark), mirror->outlines);
    if (mirror->chi2_above < -kUndecided_chi2) return false;
  }
  list_by_fit(believed, mirror, candidates);  // whichever is first, the track keeps to its side
  return true;
}

/// The mirror image of the first refiner's pose; none: there is no second pose. `chi2_above` is below zero where it
/// fits better.
std::optional<PoseCandidate> FullSolver::Workspace::weigh_mirror(const ImageView& luma, const PosePrior* prior,
                                                                 double warp_px, int& pixels) noexcept {
  is_mirror_open = false;
  OutlineState mirrored = first->state();
  const std::array<double, kDotCount> visible = first->visible_share();
  mirrored.T_camera_landmark = mirror_image(first->state().T_camera_landmark, landmark, visible);
  const double apart_rad = angle_between_rad(mirrored.T_camera_landmark, first->state().T_camera_landmark);
  if (apart_rad < kSamePose_rad) return std::nullopt;
  PoseCandidate mirror;
  mirror.pose.T_landmark_camera = mirrored.T_camera_landmark.inverse();
  mirror.outlines = mirrored;
  mirror.chi2_above = believable(first->chi2_above(mirrored, kBeyondDoubt_chi2), mirrored);
  const bool is_settled = prior != nullptr && apart_rad > kApart_rad &&
                          is_on_settled_side(*prior, first->state().T_camera_landmark, mirrored.T_camera_landmark);
  // A wrong pose of few dots has weights that suit it, and one of dots that draw lines has lines that do: by these the
  // right one is excluded by 80 to 3600.
  const bool suits_itself = dots_in_sight(visible) <= kFewDots || Smear(mirrored).parts > 1;
  const double decisive_chi2 = is_settled     ? kSettled_chi2
                               : suits_itself ? std::numeric_limits<double>::infinity()
                                              : kDecisive_chi2;
  mirror.refined = !(mirror.chi2_above > decisive_chi2);
  if (!mirror.refined) return mirror;
  const OptimiserStatistics& steps =
      second->refine(luma, mirrored, OutlineRefiner::Start::kClose, warp_px, pixels, OutlineRefiner::Light::kSimple,
                     kMuchWorse * first->fit().residual_lsb);
  if (!steps.has_converged()) {
    mirror.refined = false;
    is_mirror_open = pixels <= 0 && steps.stopped != Stopped::kLedNowhere;
    return mirror;
  }
  if (angle_between_rad(first->state().T_camera_landmark, second->state().T_camera_landmark) < kSamePose_rad)
    return std::nullopt;
  mirror = candidate_of(*second, camera, landmark);
  // Half of the difference from the pixels of either: neither's choice of pixels and weights decides.
  const double of_pixels_chi2 = 0.5 * (first->chi2_above(second->state()) - second->chi2_above(first->state()));
  const CameraFromLandmark& other = second->state().T_camera_landmark;
  const double of_places_chi2 = 0.5 * (preference(*first, other) + preference(*second, other));
  const bool contradict = of_pixels_chi2 * of_places_chi2 < 0 && std::abs(of_places_chi2) > kContradiction_chi2;
  mirror.chi2_above = contradict ? 0 : believable(of_pixels_chi2, second->state());
  return mirror;
}

/// Takes the better mirror image for the first pose, and looks at its own mirror image: that of a wrong pose, whose
/// weights suit it, may lead to a wrong one on the other side as well.
/// \param best, mirror  of the first pose; afterwards of the one that was its mirror image. Where its own mirror image
/// is excluded or none, the first pose stays the alternative
void FullSolver::Workspace::begin_with_mirror(const ImageView& luma, const PosePrior* prior, double warp_px,
                                              int& pixels, PoseCandidate& best,
                                              std::optional<PoseCandidate>& mirror) noexcept {
  std::swap(first, second);
  std::swap(best, *mirror);
  mirror->chi2_above = -std::exchange(best.chi2_above, 0);
  if (const auto own = weigh_mirror(luma, prior, warp_px, pixels); own && own->refined) mirror = own;
}

/// The pose once more where the picture's light is more than two grey levels and an offset: with the edges of shadows
/// that cross its dots, and with the tone curve of a wide blur. Which of its readings it is, is asked without: both
/// explain much of what is none.
/// \return  the tone curve is in it, and no shadow's edge
bool FullSolver::Workspace::fit_light(const ImageView& luma, const OutlineRefiner& chosen, double warp_px, int& pixels,
                                      PoseCandidate& candidate) noexcept {
  if (chosen.shadowed_dots() == 0 && chosen.tone_share() == 0) return false;
  using Refiner = OutlineRefiner;
  // A quarter is kept: other landmarks may come after this one, and without this a frame lacks nothing.
  const int kept = pixels / 4;
  int own = pixels - kept;
  const bool has_converged =
      lit.refine(luma, candidate.outlines, Refiner::Start::kClose, warp_px, own, Refiner::Light::kFull).has_converged();
  pixels = kept + std::max(own, 0);
  if (!has_converged || !(lit.has_light_edges() || lit.has_tone())) return false;
  // Sectors have more of their own than an edge has.
  if (!lit.has_light_edges() && lit.fit().residual_lsb > candidate.fit.residual_lsb) return false;
  if (lit.has_tone() && lit.fit().paper_lsb - lit.fit().contrast_lsb < kDarkest_lsb) return false;
  PoseCandidate better = candidate_of(lit, camera, landmark);
  // Light that falls over much of a dot changes what its outline looks like more than where it is: a straight edge of a
  // Gaussian's width explains the one less well than the other. Few dots say too little by their places.
  if (lit.has_penumbra() && better.pose.dots_used > kFewDots)
    if (const auto places = fit_to_places(better.dots, landmark, better.pose.T_landmark_camera.inverse()))
      better = candidate_of(*places, better, camera, landmark);
  if (!is_nearby(candidate.pose, better.pose)) return false;
  candidate.dots = better.dots;
  if (lit.has_light_edges()) {
    candidate.pose.T_landmark_camera = better.pose.T_landmark_camera;
    candidate.pose.covariance = better.pose.covariance;
    candidate.pose.ellipse = better.pose.ellipse;
    return false;
  }
  candidate.pose = better.pose;
  candidate.visible_share = better.visible_share;
  candidate.fit.residual_lsb = better.fit.residual_lsb;  // how dark the ink of small dots is, a curve leaves open
  return true;
}

FullSolver::FullSolver(const CameraModel& camera, const LandmarkGeometry& landmark, const FullSolverOptions& options)
    : workspace_(std::make_unique<Workspace>(camera, landmark, options)) {}

FullSolver::~FullSolver() = default;

Result<PoseCandidates> FullSolver::solve(const ImageView& luma, const LandmarkObservation& seen, const PosePrior* prior,
                                         int& pixels, const SheetMotion& motion) noexcept {
  Workspace& w = *workspace_;
  refused_.reset();
  NINEDOT_TRY(const Starts starts, w.starts_from(seen, prior, motion));
  w.is_mirror_open = false;
  PoseCandidates candidates;
  if (seen.seen_count > static_cast<int>(kLeastCentroids)) candidates.warp_px = kWarpShare * starts.rms_px;
  if (!w.refine_first(luma, seen, starts, prior, candidates.warp_px, pixels, motion))
    return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  PoseCandidate best = candidate_of(*w.first, w.camera, w.landmark);

  std::optional<PoseCandidate> mirror;
  if (starts.centroids_decide()) {
    mirror.emplace();
    mirror->pose.T_landmark_camera = starts.side[1].inverse();
    mirror->outlines.T_camera_landmark = starts.side[1];
    mirror->chi2_above = starts.second_chi2_above;
    mirror->refined = false;
  } else {
    mirror = w.weigh_mirror(luma, prior, candidates.warp_px, pixels);
    if (is_better(mirror) &&
        (dots_in_sight(w.second->visible_share()) <= kFewDots || mirror->chi2_above < -kUndecided_chi2))
      w.begin_with_mirror(luma, prior, candidates.warp_px, pixels, best, mirror);
  }
  // A mirror image that there was nothing left to refine with is not excluded by a glance.
  if (w.is_mirror_open) return fail(Errc::kPoseDegenerate, "the mirror image could not be looked at any more");
  const OutlineRefiner& chosen = list_by_fit(best, mirror, candidates) ? *w.second : *w.first;
  // Where a reading that is none of a landmark fits as well, the picture shows none.
  for (const PoseCandidate& reading : candidates.list)
    if (reading.refined && reading.chi2_above < kUndecided_chi2)
      if (const auto usable = check_pose(reading.pose, w.camera, w.landmark, w.options.most_sigma); !usable) {
        if (usable.error().code == Errc::kNoLandmark) refused_ = candidates;
        return tl::unexpected<Error>(usable.error());
      }
  // An edge of light explains much of what is no disc.
  const bool has_tone = w.fit_light(luma, chosen, candidates.warp_px, pixels, candidates.list[0]);
  candidates.list[0].shape = (has_tone ? w.lit : chosen).shape();
  return candidates;
}

Result<PoseCandidates> FullSolver::follow(const ImageView& luma, const PoseExpectation& expected,
                                          const PosePrior& prior, int& pixels, const SheetMotion& motion) noexcept {
  Workspace& w = *workspace_;
  const OutlineState start = start_of(prior.outlines, expected.T_camera_landmark, motion, w.camera.fx_px);
  const auto lost = fail(Errc::kNoLandmark, "the landmark is not where it was expected");
  if (!w.first->refine(luma, start, OutlineRefiner::Start::kExpected, prior.warp_px, pixels).has_converged() ||
      w.first->shadowed_dots() > kMostShadowed)
    return lost;
  PoseCandidates candidates;
  candidates.warp_px = prior.warp_px;
  PoseCandidate believed = candidate_of(*w.first, w.camera, w.landmark);
  if (expected.lacks_dots(believed)) return lost;                // before its light takes the pixels of a search
  w.fit_light(luma, *w.first, prior.warp_px, pixels, believed);  // as the one before was
  if (!expected.includes(believed)) return lost;  // before its mirror image takes the pixels that a search will need
  if (w.list_by_places(prior, believed, candidates)) return candidates;
  const auto mirror = w.weigh_mirror(luma, &prior, prior.warp_px, pixels);
  if (w.is_mirror_open) return lost;
  if (list_by_fit(believed, mirror, candidates)) {
    w.fit_light(luma, *w.second, candidates.warp_px, pixels, candidates.list[0]);
    if (!expected.includes(candidates.list[0])) return lost;
  }
  return candidates;
}

Result<PoseCandidate> FullSolver::examine(const ImageView& luma, const CameraFromLandmark& T_camera_landmark,
                                          int& pixels, const SheetMotion& motion) noexcept {
  OutlineRefiner& refiner = *workspace_->first;
  const OutlineState start = start_of({}, T_camera_landmark, motion, workspace_->camera.fx_px);
  if (!refiner.refine(luma, start, OutlineRefiner::Start::kRough, 0, pixels).has_converged())
    return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  PoseCandidate candidate = candidate_of(refiner, workspace_->camera, workspace_->landmark);
  candidate.shape = refiner.shape();
  return candidate;
}

}  // namespace ninedot
