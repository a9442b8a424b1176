// The landmark is looked for along its outlines where the track foretells them, then where it was in the frame before,
// then everywhere. The chosen solver turns it into candidates, and the track chooses among them.
#include "pipeline/localiser.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "detect/numbering.h"
#include "pipeline/report_reason.h"
#include "pose/observation_of_pose.h"
#include "pose/pose_of_outlines.h"

namespace ninedot {

std::uint16_t pose_quality(const PoseEstimate& pose) noexcept {
  constexpr double kHalfPrecision = 0.005;  // 0.5 % of the distance: what an integrator would still drive on
  const double sigma_m = std::sqrt(std::max(0.0, pose.covariance.topLeftCorner<3, 3>().trace()));
  const double ratio = sigma_m / (kHalfPrecision * pose.T_landmark_camera.translation_m.norm());
  const double precision = 1 / (1 + ratio * ratio);
  const double visible = std::clamp(pose.dots_used / static_cast<double>(kDotCount), 0.0, 1.0);
  const double unique = 1 - std::clamp(pose.ambiguity, 0.0, 1.0) / 2;
  const double quality = 1000 * precision * visible * unique;
  return std::isfinite(quality) ? static_cast<std::uint16_t>(std::lround(quality)) : std::uint16_t{0};
}

std::array<double, 6> world_sigmas(const PoseEstimate& pose,
                                   const Transform<frame::World, frame::Landmark>& T_world_landmark) noexcept {
  const Eigen::Matrix3d R_world_landmark = T_world_landmark.rotation;
  const Eigen::Matrix3d R_world_camera = R_world_landmark * pose.T_landmark_camera.rotation;
  const Eigen::Matrix3d position =
      R_world_landmark * pose.covariance.topLeftCorner<3, 3>() * R_world_landmark.transpose();
  const Eigen::Matrix3d rotation =
      R_world_camera * pose.covariance.bottomRightCorner<3, 3>() * R_world_camera.transpose();
  std::array<double, 6> sigmas{};
  for (Eigen::Index i = 0; i < 3; ++i) {
    sigmas[static_cast<std::size_t>(i)] = std::sqrt(std::max(0.0, position(i, i)));
    sigmas[static_cast<std::size_t>(i) + 3] = std::sqrt(std::max(0.0, rotation(i, i)));
  }
  return sigmas;
}

Localiser::Localiser(const CameraModel& camera, const LocaliserOptions& options)
    : options_(options),
      camera_(camera),
      detector_(camera, options.landmark, options.detector),
      full_(camera, options.landmark),
      ellipse_(camera, options.landmark, options.ellipse),
      track_({camera.fx_px, options.landmark, options.solver == Solver::kFull, options.detector.upright}) {}

Result<std::size_t> Localiser::follow_outlines(const Frame& frame) noexcept {
  const auto untrackable = fail(Errc::kNoLandmark, "its outlines can't be foretold well enough");
  if (options_.solver != Solver::kFull || !track_.may_follow_outlines()) return untrackable;
  const bool look_at_mirror = track_.must_look_at_mirror();
  NINEDOT_TRY(candidates_, full_.follow(frame.luma, track_.expected_at(frame.exposed_at()), *track_.prior(),
                                        look_at_mirror, budget_.pixels));
  const PoseCandidate& followed = candidates_.list[0];
  if (!track_.accepts(followed, frame.exposed_at()) || !fits_picture(followed, noise_))
    return fail(Errc::kNoLandmark, "the landmark is not as it was");
  track_.see(observation_of(followed.outlines.T_camera_landmark, followed.visible_share, camera_, options_.landmark));
  return track_.take(candidates_, look_at_mirror, frame.exposed_at());
}

Result<std::size_t> Localiser::detect_near_track(const Frame& frame) noexcept {
  NINEDOT_TRY(const LandmarkObservation seen,
              detector_.find_landmark_near(frame.luma, track_.forecast(frame.exposed_at()), budget_));
  return solve(frame, seen, track_.prior());
}

Result<std::size_t> Localiser::search(const Frame& frame) noexcept {
  track_.jump();
  const std::size_t guess = std::exchange(next_guess_, 0);
  Result<std::size_t> chosen = fail(Errc::kNoLandmark, "nothing in the picture is a landmark");
  const auto try_guess = [&](const LandmarkObservation& seen) {
    if (!chosen) chosen = solve_guess(frame, seen);
    return chosen || budget_.pixels > 0;
  };
  NINEDOT_TRY(const auto likely, detector_.find_landmarks(frame.luma, budget_));
  if (guess == 0 && (!try_guess(likely.front()) || chosen)) return chosen;
  NINEDOT_TRY(const auto unlikely, detector_.find_more_landmarks(frame.luma, budget_));
  std::size_t begin_at = guess > 0 ? guess - 1 : 0;
  const std::size_t tried =
      go_round(unlikely.size(), begin_at, [&](std::size_t rank) { return try_guess(unlikely[rank]); });
  if (tried < unlikely.size()) next_guess_ = begin_at + 1;
  return chosen;
}

/// What looks like the landmark, though nothing has told yet where it is.
Result<std::size_t> Localiser::solve_guess(const Frame& frame, LandmarkObservation seen) noexcept {
  // Only the priors have numbered it. What was tracked a moment ago keeps its numbers.
  if (const auto known = track_.remembered(frame.exposed_at()))
    if (const auto first = first_dot_by_forecast(seen.H_ray_plane, known->H_ray_plane, options_.landmark))
      seen = renumbered(seen, *first);
  return solve(frame, seen, nullptr);
}

Result<std::size_t> Localiser::solve(const Frame& frame, const LandmarkObservation& seen,
                                     const PosePrior* prior) noexcept {
  const bool full = options_.solver == Solver::kFull;
  const auto answer = full ? full_.solve(frame.luma, seen, prior, budget_.pixels) : ellipse_.solve(seen);
  if (!answer) {
    if (answer.error().code == Errc::kPoseDegenerate) track_.see(seen);
    return tl::unexpected<Error>(answer.error());
  }
  candidates_ = *answer;
  const PoseCandidate& best = candidates_.list[0];
  // The closed form looks at centres alone: whether there are outlines of a landmark is asked of the picture apart.
  const Result<PoseCandidate> examined =
      full ? best : full_.examine(frame.luma, best.pose.T_landmark_camera.inverse(), budget_.pixels);
  if (!examined || !fits_picture(*examined, noise_)) {
    if (!misfit_ && is_publishable(best.pose)) misfit_ = candidates_;
    return fail(Errc::kNoLandmark, "the picture does not fit a landmark");
  }
  track_.see(seen);
  return track_.take(candidates_, true, frame.exposed_at());
}

void Localiser::add_fix(std::size_t chosen, bool fits) noexcept {
  const MappedLandmark& landmark = options_.map.landmarks().front();
  LandmarkFix fix;
  fix.id = landmark.id;
  fix.candidates = candidates_;
  fix.chosen = chosen;
  const PoseEstimate& pose = fix.pose();
  fix.T_world_camera = landmark.T_world_landmark * pose.T_landmark_camera;
  fix.sigma_world = world_sigmas(pose, landmark.T_world_landmark);
  fix.quality = pose_quality(pose);
  fix.verdict = verdict_on(pose, fits, options_.trust);
  fix_.reason = fix.verdict;
  (void)fix_.landmarks.try_push_back(fix);  // the only one
}

const Fix& Localiser::process(const Frame& frame) noexcept {
  const MonoTime begin = mono_now();
  fix_.landmarks.clear();
  fix_.calibrated = options_.calibrated;
  fix_.solver = options_.solver;
  noise_ = PictureNoise(frame.luma);
  misfit_.reset();
  budget_ = options_.budget;

  // Without tracking a frame's answer depends on that frame alone.
  if (!options_.tracking || track_.is_numbering_refuted()) track_.reset();
  const bool has_track = options_.tracking && track_.has_sighting() && next_guess_ == 0;
  Result<std::size_t> chosen = fail(Errc::kNoLandmark, "there is no track");
  if (has_track) chosen = follow_outlines(frame);
  if (has_track && !chosen) chosen = detect_near_track(frame);
  fix_.tracked = chosen.has_value();
  if (!chosen) chosen = search(frame);  // the landmark jumped, or what was near the track is not it

  if (chosen) {
    add_fix(*chosen, true);
  } else {
    track_.lose_pose(track_.has_sighting());
    fix_.reason = reason_of(chosen.error().code);
    const bool out_of_pixels = budget_.pixels <= 0;
    // What was tried first comes last in the next frame.
    if (out_of_pixels && next_guess_ == 0) next_guess_ = 1;
    budget_.is_overdrawn |= out_of_pixels;
    if (out_of_pixels || (fix_.reason == Reason::kNoLandmark && budget_.is_overdrawn)) fix_.reason = Reason::kCrowded;
    if (misfit_) {
      candidates_ = *misfit_;
      add_fix(0, false);
    }
  }
  fix_.found = track_.has_sighting() || !fix_.landmarks.empty();
  if (budget_.is_overdrawn) ++frames_cut_;
  fix_.work = detector_.counts();
  fix_.work.frames_cut = frames_cut_;
  fix_.process_time = mono_now() - begin;
  return fix_;
}

}  // namespace ninedot
