#include "pipeline/landmark_seeker.h"

#include <array>
#include <optional>

#include "detect/numbering.h"
#include "geometry/planar_pose.h"
#include "pipeline/retaken_rows.h"
#include "pose/observation_of_pose.h"

namespace ninedot {
namespace {

// Beside other landmarks one is of use by its direction and its distance, whatever its tilt. Pattern: rendered rooms, 5
// to 6.4 m.
constexpr FullSolverOptions kInRooms{.most_sigma = 1, .pattern_px = 0.1};
// Of two things that were made alike: their sizes in the picture, as far as the two poses know them.
constexpr double kAsLarge = 0.9;
// Of what is left of a frame's pixels, by which a look at what may not be there is to get along: a smeared landmark
// that is there takes a sixth of all.
constexpr int kShareOfLook = 4;

FullSolverOptions full_options(const SeekerOptions& options) noexcept {
  FullSolverOptions full = options.has_map ? kInRooms : FullSolverOptions{};
  full.regards_walls = options.regards_walls;
  return full;
}

}  // namespace

LandmarkSeeker::LandmarkSeeker(const CameraModel& camera, const SeekerOptions& options)
    : options_(options),
      camera_(camera),
      detector_(camera, options.landmark, options.detector),
      full_(camera, options.landmark, full_options(options)),
      ellipse_(camera, options.landmark, options.ellipse) {}

void LandmarkSeeker::begin(const Frame& frame, const WorkBudget& budget, const RowTime& rows, double exposure_s,
                           const std::optional<CameraTwist>& twist) noexcept {
  frame_at_ = frame.exposed_at();
  unrest_.begin(frame_at_);
  rows_ = rows;
  exposure_s_ = exposure_s;
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
  if (!(rows_differ() || exposure_s_ > 0) || twist_ || track.motion_at(frame_at_)) return std::nullopt;
  return track.motion_across(t_camera_m.hnormalized(), frame_at_);
}

/// What a fit takes for its motion. \param track  of the landmark, before this frame \param t_camera_m  where it is,
/// about \param is_seen_there  its dots are, in this frame; else it is expected there
LandmarkSeeker::KnownMotion LandmarkSeeker::motion_of(const Track& track, const Eigen::Vector3d& t_camera_m,
                                                      bool is_seen_there) const noexcept {
  const auto own = track.motion_at(frame_at_);
  const auto across = is_seen_there ? first_motion(track, t_camera_m) : std::nullopt;
  KnownMotion motion;
  motion.sheet = with_shutter(own ? *own : twist_ ? twist_->of_sheet_at(t_camera_m) : across.value_or(SheetMotion{}));
  // A track that foretells the motion, or has seen it come here, will have measured it afterwards.
  motion.rate_sigma_rad_s =
      !own && twist_ ? std::hypot(twist_->rate_sigma_rad_s, unrest_.unexpected_rad_s()) : unrest_.speed_rad_s();
  return motion;
}

SheetMotion LandmarkSeeker::with_shutter(SheetMotion motion) const noexcept {
  motion.row_time_s = rows_.mean_s;
  motion.exposure_s = exposure_s_;
  motion.middle_row_px = 0.5 * (camera_.height_px - 1);
  return motion;
}

/// 1-sigma, of the speed that a track has measured: what it gained since the middle of its two frames, or by how much
/// it gains ever more: a third of what that changes the speed from one frame to the next.
double LandmarkSeeker::rate_sigma(const MeasuredMotion& measured) const noexcept {
  const double unknown_rad_s2 =
      measured.gain ? measured.gain->change_1_s2.norm() / 3 : unrest_.acceleration_rad_s2() / 2;
  return std::hypot(measured.noise_rad_s, measured.over_s * unknown_rad_s2);
}

/// What fits into the track, and by what the track knows of the motion then. \param taken  what the fit took for it
Result<std::size_t> LandmarkSeeker::take(const KnownMotion& taken, Track& track) noexcept {
  NINEDOT_TRY(const std::size_t chosen, track.take(candidates_, frame_at_));
  KnownMotion known = taken;
  const Eigen::Vector3d t_m = candidates_.list[chosen].pose.T_landmark_camera.inverse().translation_m;
  if (const auto measured = track.motion_now()) {
    unrest_.note(measured->sheet.ray_velocity(t_m, t_m).norm(),
                 measured->gain ? measured->gain->acceleration_1_s2.norm() : 0);
    if (const double sigma_rad_s = rate_sigma(*measured); sigma_rad_s < taken.rate_sigma_rad_s) {
      // How a sheet turns one landmark tells poorly: that stays.
      known.sheet = with_shutter({taken.sheet.rotation_rad_s, measured->sheet.translation_m_s});
      known.rate_sigma_rad_s = sigma_rad_s;
      for (PoseCandidate& candidate : candidates_.list)
        retake_rows(candidate, taken.sheet, known.sheet, options_.landmark, camera_);
    }
  }
  row_motion_ = {known.sheet, uncertainty(known, t_m)};
  return chosen;
}

/// Of the product of how it moves and of the row time.
RowUncertainty LandmarkSeeker::uncertainty(const KnownMotion& motion,
                                           const Eigen::Vector3d& t_camera_m) const noexcept {
  const double moves_1_s = motion.sheet.ray_velocity(t_camera_m, t_camera_m).norm();
  return {motion.rate_sigma_rad_s * std::abs(rows_.mean_s), moves_1_s * rows_.sigma_s,
          motion.rate_sigma_rad_s * rows_.sigma_s, motion.sheet.middle_row_px};
}

FitAllowance LandmarkSeeker::allowance(bool is_foretold) const noexcept {
  if (!options_.has_map) return {};
  return {is_foretold ? kForetoldMisfit_px : 0, true};
}

Result<std::size_t> LandmarkSeeker::follow_outlines(Track& track) noexcept {
  const auto untrackable = fail(Errc::kNoLandmark, "its outlines can't be foretold well enough");
  if (options_.solver != Solver::kFull || !track.may_follow_outlines()) return untrackable;
  const PoseExpectation expected = track.expectation(frame_at_);
  const KnownMotion motion = motion_of(track, expected.T_camera_landmark.translation_m, false);
  NINEDOT_TRY(candidates_, full_.follow(luma_, expected, *track.prior(), budget_.pixels, motion.sheet));
  const PoseCandidate& followed = candidates_.list[0];
  if (!fits_picture(followed, noise_, allowance(true))) return fail(Errc::kNoLandmark, "the landmark is not as it was");
  track.see(observation_of(as_exposed(followed.outlines.T_camera_landmark, motion.sheet, camera_),
                           followed.visible_share, camera_, options_.landmark));
  return take(motion, track);
}

Result<std::size_t> LandmarkSeeker::detect_near_track(Track& track) noexcept {
  // The window's margin holds what a rolling shutter makes of the forecast.
  NINEDOT_TRY(const LandmarkObservation seen, detector_.find_landmark_near(luma_, track.forecast(frame_at_), budget_));
  return solve(seen, track.prior(), track, true);
}

Result<std::size_t> LandmarkSeeker::solve_guess(LandmarkObservation seen, Track& track) noexcept {
  // Only the priors have numbered it.
  if (const auto known = track.remembered(frame_at_))
    if (const auto first = first_dot_by_forecast(seen.H_ray_plane, known->H_ray_plane, options_.landmark))
      seen = renumbered(seen, *first);
  return solve(seen, nullptr, track);
}

void LandmarkSeeker::show_three_dots(const LandmarkObservation& seen) noexcept {
  if (misfit_ || budget_.pixels <= 0) return;
  const auto answer = full_.solve(luma_, seen, nullptr, budget_.pixels, {});
  if (!answer || !is_publishable(answer->list[0].pose)) return;
  misfit_ = *answer;
  if (fits_picture(answer->list[0], noise_, allowance(false))) misfit_reason_ = Reason::kPoseDegenerate;
}

Result<std::size_t> LandmarkSeeker::look_at(const CameraFromLandmark& T_camera_landmark, Track& track) noexcept {
  const SheetMotion motion = motion_of(track, T_camera_landmark.translation_m, false).sheet;
  std::array<double, kDotCount> all_visible;
  all_visible.fill(1);
  // What is not there leads its fit astray for long, and a search may have to come after it.
  const int kept = budget_.pixels - budget_.pixels / kShareOfLook;
  budget_.pixels -= kept;
  const auto chosen =
      solve(observation_of(as_exposed(T_camera_landmark, motion, camera_), all_visible, camera_, options_.landmark),
            nullptr, track, true);
  budget_.pixels += kept;
  return chosen;
}

Result<std::size_t> LandmarkSeeker::solve(const LandmarkObservation& seen, const PosePrior* prior, Track& track,
                                          bool is_foretold) noexcept {
  const bool full = options_.solver == Solver::kFull;
  const Eigen::Vector3d t_m = depth_of_origin(seen.H_ray_plane) * seen.H_ray_plane.col(2) / seen.H_ray_plane(2, 2);
  const KnownMotion motion = motion_of(track, t_m, !seen.from_pose);
  const auto answer = full ? full_.solve(luma_, seen, prior, budget_.pixels, motion.sheet) : ellipse_.solve(seen);
  if (!answer) {
    if (answer.error().code == Errc::kPoseDegenerate) track.see(seen);
    // Nine dots about where a landmark's would be a person sees at once, whatever is wrong with them.
    const auto& refused = full_.refused();
    if (full && refused && !misfit_ && !is_foretold && has_whole_ring(refused->list[0]) &&
        is_publishable(refused->list[0].pose))
      misfit_ = refused;
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
  fits_black_and_white_ = !is_one_of_many && fits_picture(*examined, noise_, {allowance(is_foretold).misfit_px, false});
  track.see(seen);
  return take(motion, track);
}

}  // namespace ninedot
