#include "pose/full_solver.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/planar_pose.h"
#include "pose/ellipse_parameters.h"
#include "pose/observation_of_pose.h"
#include "pose/outline_refiner.h"

// Start from the dots' centroids (both planar solutions), refine along the outlines what the centroids do not exclude,
// and let the grey levels decide.

namespace ninedot {
namespace {

constexpr double kCentroidSigma_px =
    0.15;                                 // of a blob, at best, for telling the two planar solutions apart at a glance
constexpr std::size_t kMinCentroids = 5;  // for a start from centroids
constexpr double kDecisive = 60;          // difference of chi^2 above which the other solution is not even refined
constexpr double kUndecided = 9;          // and below which the picture can't tell (3 sigma)
constexpr double kSamePose_rad = 0.005;   // two solutions closer than this are one
constexpr double kSettled = 1e-4;         // ambiguity of a track that has told the two solutions apart,
constexpr double kSettledDifference = 18.4;  // the difference of chi^2 that belongs to it
constexpr double kApart_rad = 0.17;          // the two solutions' angle from which a track tells them apart
constexpr double kCloseStart_px = 0.4;       // residual of centroids that a track may start from at once
constexpr double kWarpShare = 0.5;  // of the centroids' residual: what of it may be the sheet's warp or a shadow's pull
constexpr double kCommonShift_px =
    0.002;                          // of all outlines alike, beyond noise: rendered sRGB pictures, tone-curve residue
constexpr double kMaxMisfit = 0.3;  // of a dot's radius: what is further off is no print of the landmark
constexpr double kMaxSigma = 0.1;   // of the distance: whoever knows no more has no position

double angle_between(const CameraFromLandmark& a, const CameraFromLandmark& b) noexcept {
  return log_so3(a.rotation.transpose() * b.rotation).norm();
}

}  // namespace

struct FullSolver::Workspace {
  Workspace(const CameraModel& camera_model, const LandmarkGeometry& landmark_geometry)
      : camera(camera_model),
        landmark(landmark_geometry),
        rays(camera_model),
        refiners{OutlineRefiner(camera, landmark, rays), OutlineRefiner(camera, landmark, rays)} {}

  Result<PlanarPoses> start_from_centroids(const LandmarkObservation& seen) const noexcept;
  double centroids_against(const PlanarPoses& starts, const LandmarkObservation& seen) const noexcept;
  CameraFromLandmark other_solution(const CameraFromLandmark& T) const noexcept;
  double choose(OutlineRefiner*& best, OutlineRefiner*& other, const PoseEstimate* previous) const noexcept;
  PoseEstimate conclude(const OutlineRefiner& best, double ambiguity) const noexcept;
  /// The ambiguity that the mirror image of a refined pose leaves; none: it has to be refined as well.
  std::optional<double> mirror_left_over(const OutlineRefiner& refiner, bool track_settled) const noexcept;

  CameraModel camera;
  LandmarkGeometry landmark;
  RayTable rays;
  std::array<OutlineRefiner, 2> refiners;
  OutlineState last;        ///< of the frame before; its blur and offset are the camera's more than the frame's
  double last_warp_px = 0;  ///< the sheet's, likewise
  bool last_light_smooth = false;
  int frames_unmirrored = 0;  ///< since follow() looked at the mirror image
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

/// How much worse the second start fits the centroids than the first, as a difference of chi^2; 0 where they can't
/// tell.
double FullSolver::Workspace::centroids_against(const PlanarPoses& starts,
                                                const LandmarkObservation& seen) const noexcept {
  // A start from the detector's map fits itself: its residuals say nothing.
  if (seen.seen_count < static_cast<int>(kMinCentroids)) return 0;
  const double sigma_px = std::max(kCentroidSigma_px, starts[0].rms * camera.fx_px);
  const double scale = camera.fx_px / sigma_px;
  return 2 * seen.seen_count * (std::pow(starts[1].rms * scale, 2) - std::pow(starts[0].rms * scale, 2));
}

/// The pose from which the dots' centres look most like those of `T`, on the other side of the sheet's normal.
CameraFromLandmark FullSolver::Workspace::other_solution(const CameraFromLandmark& T) const noexcept {
  InlineVector<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = landmark.centre_m(dot);
    (void)points.try_push_back({C, (T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized()});
  }
  const auto poses = solve_planar_pose(points.span());
  if (!poses) return T;
  const CameraFromLandmark &a = (*poses)[0].T_camera_landmark, &b = (*poses)[1].T_camera_landmark;
  return angle_between(a, T) > angle_between(b, T) ? a : b;
}

std::optional<double> FullSolver::Workspace::mirror_left_over(const OutlineRefiner& refiner,
                                                              bool track_settled) const noexcept {
  OutlineState mirrored = refiner.state();
  mirrored.T_camera_landmark = other_solution(refiner.state().T_camera_landmark);
  const double apart_rad = angle_between(mirrored.T_camera_landmark, refiner.state().T_camera_landmark);
  if (apart_rad < kSamePose_rad) return 0;
  const double worse_by = refiner.chi2_above(mirrored);
  if (worse_by < (track_settled && apart_rad > kApart_rad ? kSettledDifference : kDecisive)) return std::nullopt;
  return std::exp(-0.5 * worse_by);
}

/// Makes `best` the better of two refined solutions. \return the ambiguity
double FullSolver::Workspace::choose(OutlineRefiner*& best, OutlineRefiner*& other,
                                     const PoseEstimate* previous) const noexcept {
  if (angle_between(best->state().T_camera_landmark, other->state().T_camera_landmark) < kSamePose_rad) return 0;
  // Half of the difference from the pixels of either: neither's choice of pixels and weights decides.
  const double better_by = 0.5 * (best->chi2_above(other->state()) - other->chi2_above(best->state()));
  bool other_wins = better_by < 0;
  if (previous != nullptr && std::abs(better_by) < kUndecided) {
    const auto turn = [&](const OutlineRefiner& r) {
      return log_so3(previous->T_landmark_camera.rotation * r.state().T_camera_landmark.rotation).norm();
    };
    other_wins = turn(*other) < turn(*best);
  }
  if (other_wins) std::swap(best, other);
  return std::exp(-0.5 * std::abs(better_by));
}

PoseEstimate FullSolver::Workspace::conclude(const OutlineRefiner& best, double ambiguity) const noexcept {
  PoseEstimate pose;
  const CameraFromLandmark& T = best.state().T_camera_landmark;
  pose.T_landmark_camera = T.inverse();
  pose.ambiguity = ambiguity;
  pose.rms_px = best.rms_px();
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
  const UnknownMatrix all = best.information().inverse();
  pose.covariance = M * all.topLeftCorner<6, 6>() * M.transpose();
  pose.covariance = 0.5 * (pose.covariance + pose.covariance.transpose()).eval();
  pose.covariance.bottomRightCorner<3, 3>().diagonal().array() += std::pow(kCommonShift_px / camera.fx_px, 2);

  const std::array<double, kDotCount> visible = best.visible_share();
  int ring_missing = 0;
  bool centre_missing = false;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    pose.dots_used += visible[dot] >= kMinVisible;
    if (visible[dot] >= 0.5) continue;
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
                                       const PoseEstimate* previous) noexcept {
  Workspace& w = *workspace_;
  NINEDOT_TRY(PlanarPoses starts, w.start_from_centroids(seen));
  const auto turn_since = [&](const CameraFromLandmark& T) {
    return log_so3(previous->T_landmark_camera.rotation * T.rotation).norm();
  };
  const double apart_rad = angle_between(starts[0].T_camera_landmark, starts[1].T_camera_landmark);
  const double coarse = w.centroids_against(starts, seen);
  const bool undecided = apart_rad >= kSamePose_rad && coarse < kDecisive;
  // A track that has told the two solutions apart begins with the one that it is in, and needs less to stay in it.
  const bool settled = previous != nullptr && previous->ambiguity < kSettled && apart_rad > kApart_rad;
  if (undecided && settled && turn_since(starts[1].T_camera_landmark) < turn_since(starts[0].T_camera_landmark))
    std::swap(starts[0], starts[1]);

  OutlineState start = previous != nullptr ? w.last : OutlineState{};
  start.T_camera_landmark = starts[0].T_camera_landmark;
  const bool close = previous != nullptr && seen.seen_count >= static_cast<int>(kMinCentroids) &&
                     starts[0].rms * w.camera.fx_px < kCloseStart_px;
  const double warp_px =
      seen.seen_count > static_cast<int>(kMinCentroids) ? kWarpShare * starts[0].rms * w.camera.fx_px : 0;
  OutlineRefiner* best = &w.refiners[0];
  OutlineRefiner* other = &w.refiners[1];
  bool ok = best->refine(luma, start, close ? OutlineRefiner::Start::kClose : OutlineRefiner::Start::kRough, warp_px)
                .has_converged();
  double ambiguity = apart_rad < kSamePose_rad ? 0 : std::exp(-0.5 * std::max(coarse, 0.0));
  if (undecided) {
    OutlineState glance = ok ? best->state() : start;
    glance.T_camera_landmark = ok ? w.other_solution(best->state().T_camera_landmark) : starts[1].T_camera_landmark;
    const double worse_by = ok ? best->chi2_above(glance) : 0;
    if (worse_by > (settled ? kSettledDifference : kDecisive)) {
      ambiguity = std::exp(-0.5 * worse_by);
    } else if (other->refine(luma, glance, ok ? OutlineRefiner::Start::kClose : OutlineRefiner::Start::kRough, warp_px)
                   .has_converged()) {
      if (!ok) {
        ambiguity = 0;
        std::swap(best, other);
        ok = true;
      } else {
        ambiguity = w.choose(best, other, previous);
      }
    }
  }
  if (!ok) return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  PoseEstimate pose = w.conclude(*best, std::min(ambiguity, 1.0));
  const double dot_px = w.camera.fx_px * w.landmark.dot_radius_m / pose.T_landmark_camera.translation_m.norm();
  if (pose.rms_px > kMaxMisfit * dot_px)
    return fail(Errc::kNoLandmark, "the outlines do not lie where those of one landmark would");
  const double sigma_m = std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace());
  if (!(sigma_m < kMaxSigma * pose.T_landmark_camera.translation_m.norm()) || pose.dots_used < 3)
    return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  w.last = best->state();
  w.last_warp_px = warp_px;
  w.last_light_smooth = best->is_light_smooth();
  return pose;
}

Result<PoseEstimate> FullSolver::follow(const ImageView& luma, const CameraFromLandmark& expected,
                                        const PoseEstimate& previous, LandmarkObservation& seen) noexcept {
  constexpr double kWorseFit = 1.5;  // times the residual of the frame before, and a bit: something else is in sight
  constexpr double kBit_px = 0.03;
  constexpr double kOutOfTheQuestion = 1e-9;  // ambiguity
  constexpr int kMirrorEvery = 4;             // frames
  Workspace& w = *workspace_;
  OutlineRefiner& refiner = w.refiners[0];
  OutlineState start = w.last;
  start.T_camera_landmark = expected;
  const auto lost = fail(Errc::kNoLandmark, "the landmark is not where it was expected");
  // Where shadows cut the dots, their centroids know better than the frame before how far to trust the outlines.
  if (!w.last_light_smooth ||
      !refiner.refine(luma, start, OutlineRefiner::Start::kExpected, w.last_warp_px).has_converged() ||
      !refiner.is_light_smooth())
    return lost;
  // A mirror image that is out of the question does not come back within four frames.
  double ambiguity = previous.ambiguity;
  if (previous.ambiguity > kOutOfTheQuestion || ++w.frames_unmirrored >= kMirrorEvery) {
    const auto left = w.mirror_left_over(refiner, previous.ambiguity < kSettled);
    if (!left) return lost;
    ambiguity = *left;
    w.frames_unmirrored = 0;
  }
  const PoseEstimate pose = w.conclude(refiner, ambiguity);
  if (pose.dots_used < previous.dots_used || pose.rms_px > kWorseFit * previous.rms_px + kBit_px) return lost;
  w.last = refiner.state();
  seen = observation_of(refiner.state().T_camera_landmark, refiner.visible_share(), w.camera, w.landmark);
  return pose;
}

}  // namespace ninedot
