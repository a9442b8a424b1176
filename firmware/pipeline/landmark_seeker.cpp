#include "pipeline/landmark_seeker.h"

#include <array>
#include <optional>

#include "detect/numbering.h"
#include "pose/observation_of_pose.h"

namespace ninedot {
namespace {

// Of a landmark that was in two frames: 0.05 px of noise each, 35 frames a second, at a focal length of 600 px.
constexpr double kFollowedRate_rad_s = 0.004;
// Of one that was detected in both: 0.2 px of each middle, dots of 3 px under motion blur.
constexpr double kSeenRate_rad_s = 0.02;
// Of a camera of which nothing is known: a robot that turns at 40 degrees per second.
constexpr double kUnknownRate_rad_s = 0.7;
// Beside other landmarks one is of use by its direction and its distance, whatever its tilt. Pattern: rendered rooms, 5
// to 6.4 m.
constexpr FullSolverOptions kInRooms{.most_sigma = 1, .pattern_px = 0.1};
// Of two things that were made alike: their sizes in the picture, as far as the two poses know them.
constexpr double kAsLarge = 0.9;

}  // namespace

LandmarkSeeker::LandmarkSeeker(const CameraModel& camera, const SeekerOptions& options)
    : options_(options),
      camera_(camera),
      detector_(camera, options.landmark, options.detector),
      full_(camera, options.landmark, options.has_map ? kInRooms : FullSolverOptions{}),
      ellipse_(camera, options.landmark, options.ellipse) {}

void LandmarkSeeker::begin(const Frame& frame, const WorkBudget& budget, const RowTime& rows,
                           const std::optional<CameraTwist>& twist) noexcept {
  frame_at_ = frame.exposed_at();
  rows_ = rows;
  twist_ = twist;
  noise_ = PictureNoise(frame.luma);
  luma_ = frame.luma;
  luma_.has_pattern = !frame.chroma.empty();
  budget_ = budget;
  misfit_.reset();
  misfit_reason_ = Reason::kPoorFit;
  look_alike_px_ = 0;
}

FailedSearch LandmarkSeeker::failed_search() const noexcept {
  FailedSearch failed = detector_.failed_search();
  if (!misfit_) return failed;
  std::array<double, kDotCount> all_of_each;
  all_of_each.fill(1);
  failed.refusal = misfit_reason_ == Reason::kPoorFit ? Refusal::kPoorFit : Refusal::kFewOutlines;
  failed.dots =
      observation_of(misfit_->list[0].pose.T_landmark_camera.inverse(), all_of_each, camera_, options_.landmark).dots;
  return failed;
}

/// What two frames tell of a landmark that nothing more is known of. \param t_camera_m  where it is seen in this one
std::optional<SheetMotion> LandmarkSeeker::first_motion(const Track& track,
                                                        const Eigen::Vector3d& t_camera_m) const noexcept {
  if (!rows_differ() || twist_ || track.motion_at(frame_at_)) return std::nullopt;
  return track.motion_across(t_camera_m.hnormalized(), frame_at_);
}

/// \param track  of the landmark, before this frame \param t_camera_m  where it is, about
/// \param is_seen_there  its dots are, in this frame; else it is expected there
RowMotion LandmarkSeeker::motion_of(const Track& track, const Eigen::Vector3d& t_camera_m,
                                    bool is_seen_there) const noexcept {
  const auto own = track.motion_at(frame_at_);
  const auto across = is_seen_there ? first_motion(track, t_camera_m) : std::nullopt;
  RowMotion motion;
  motion.sheet = own ? *own : twist_ ? twist_->of_sheet_at(t_camera_m) : across.value_or(SheetMotion{});
  motion.sheet.row_time_s = rows_.mean_s;
  motion.sheet.middle_row_px = 0.5 * (camera_.height_px - 1);
  const double rate_sigma_rad_s = own      ? kFollowedRate_rad_s
                                  : twist_ ? twist_->rate_sigma_rad_s
                                  : across ? kSeenRate_rad_s
                                           : kUnknownRate_rad_s;
  motion.uncertainty = uncertainty(motion.sheet, t_camera_m, rate_sigma_rad_s);
  return motion;
}

/// Of the product of how it moves and of the row time.
RowUncertainty LandmarkSeeker::uncertainty(const SheetMotion& motion, const Eigen::Vector3d& t_camera_m,
                                           double rate_sigma_rad_s) const noexcept {
  const double moves_1_s = motion.ray_velocity(t_camera_m, t_camera_m).norm();
  return {rate_sigma_rad_s * std::abs(rows_.mean_s), moves_1_s * rows_.sigma_s, rate_sigma_rad_s * rows_.sigma_s,
          motion.middle_row_px};
}

FitAllowance LandmarkSeeker::allowance(bool is_foretold) const noexcept {
  if (!options_.has_map) return {};
  return {is_foretold ? kForetoldMisfit_px : 0, true};
}

Result<std::size_t> LandmarkSeeker::follow_outlines(const Frame& frame, Track& track) noexcept {
  const auto untrackable = fail(Errc::kNoLandmark, "its outlines can't be foretold well enough");
  if (options_.solver != Solver::kFull || !track.may_follow_outlines()) return untrackable;
  const PoseExpectation expected = track.expectation(frame.exposed_at());
  const RowMotion motion = motion_of(track, expected.T_camera_landmark.translation_m, false);
  NINEDOT_TRY(candidates_, full_.follow(luma_, expected, *track.prior(), budget_.pixels, motion.sheet));
  const PoseCandidate& followed = candidates_.list[0];
  if (!fits_picture(followed, noise_, allowance(true))) return fail(Errc::kNoLandmark, "the landmark is not as it was");
  row_motion_ = motion;
  // It was fitted as if it stood still, and is found where it nearly did: what it moved is all that was left out.
  const Eigen::Vector3d now_m = followed.pose.T_landmark_camera.inverse().translation_m;
  if (const auto across = first_motion(track, now_m))
    row_motion_.uncertainty =
        uncertainty(motion.sheet, now_m, kSeenRate_rad_s + across->translation_m_s.norm() / now_m.z());
  track.see(observation_of(as_exposed(followed.outlines.T_camera_landmark, motion.sheet, camera_),
                           followed.visible_share, camera_, options_.landmark));
  return track.take(candidates_, frame.exposed_at());
}

Result<std::size_t> LandmarkSeeker::detect_near_track(const Frame& frame, Track& track) noexcept {
  // The window's margin holds what a rolling shutter makes of the forecast.
  NINEDOT_TRY(const LandmarkObservation seen,
              detector_.find_landmark_near(frame.luma, track.forecast(frame.exposed_at()), budget_));
  return solve(frame, seen, track.prior(), track, true);
}

Result<std::size_t> LandmarkSeeker::solve_guess(const Frame& frame, LandmarkObservation seen, Track& track) noexcept {
  // Only the priors have numbered it.
  if (const auto known = track.remembered(frame.exposed_at()))
    if (const auto first = first_dot_by_forecast(seen.H_ray_plane, known->H_ray_plane, options_.landmark))
      seen = renumbered(seen, *first);
  return solve(frame, seen, nullptr, track);
}

void LandmarkSeeker::show_three_dots(const LandmarkObservation& seen) noexcept {
  if (misfit_ || budget_.pixels <= 0) return;
  const auto answer = full_.solve(luma_, seen, nullptr, budget_.pixels, {});
  if (!answer || !is_publishable(answer->list[0].pose)) return;
  misfit_ = *answer;
  if (fits_picture(answer->list[0], noise_, allowance(false))) misfit_reason_ = Reason::kPoseDegenerate;
}

Result<std::size_t> LandmarkSeeker::look_at(const Frame& frame, const CameraFromLandmark& T_camera_landmark,
                                            Track& track) noexcept {
  const SheetMotion motion = motion_of(track, T_camera_landmark.translation_m, false).sheet;
  std::array<double, kDotCount> all_visible;
  all_visible.fill(1);
  return solve(frame,
               observation_of(as_exposed(T_camera_landmark, motion, camera_), all_visible, camera_, options_.landmark),
               nullptr, track, true);
}

Result<std::size_t> LandmarkSeeker::solve(const Frame& frame, const LandmarkObservation& seen, const PosePrior* prior,
                                          Track& track, bool is_foretold) noexcept {
  const bool full = options_.solver == Solver::kFull;
  const double scale = 0.5 * (seen.H_ray_plane.col(0).norm() + seen.H_ray_plane.col(1).norm());
  const RowMotion motion = motion_of(track, seen.H_ray_plane.col(2) / scale, !seen.from_pose);
  const auto answer = full ? full_.solve(luma_, seen, prior, budget_.pixels, motion.sheet) : ellipse_.solve(seen);
  if (!answer) {
    if (answer.error().code == Errc::kPoseDegenerate) track.see(seen);
    return tl::unexpected<Error>(answer.error());
  }
  candidates_ = *answer;
  const PoseCandidate& best = candidates_.list[0];
  // The closed form looks at centres alone: whether there are outlines of a landmark is asked of the picture apart.
  const Result<PoseCandidate> examined =
      full ? best : full_.examine(luma_, best.pose.T_landmark_camera.inverse(), budget_.pixels, motion.sheet);
  const bool is_guess = !is_foretold;
  // Wallpaper, perforated sheet: what is too small to be told from a landmark is more of what was near enough.
  const bool is_one_of_many = is_guess && examined && examined->dot_radius_px < kAsLarge * look_alike_px_;
  if (!examined || (!options_.has_map && is_one_of_many) || !fits_picture(*examined, noise_, allowance(is_foretold))) {
    if (is_guess && examined && has_whole_ring(*examined) && examined->dot_radius_px >= look_alike_px_)
      look_alike_px_ = examined->dot_radius_px;
    if (!misfit_ && is_publishable(best.pose)) misfit_ = candidates_;
    return fail(Errc::kNoLandmark, "the picture does not fit a landmark");
  }
  row_motion_ = motion;
  fits_black_and_white_ = !is_one_of_many && fits_picture(*examined, noise_, {allowance(is_foretold).misfit_px, false});
  track.see(seen);
  return track.take(candidates_, frame.exposed_at());
}

}  // namespace ninedot
