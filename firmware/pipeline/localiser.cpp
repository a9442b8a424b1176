// The landmark is looked for along its outlines where the track foretells them, then where it was in the frame before,
// then everywhere. The chosen solver turns it into candidates, and the track chooses among them.
#include "pipeline/localiser.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/contract.h"
#include "geometry/renumbered.h"
#include "pipeline/fix_uncertainty.h"
#include "pipeline/picture_row_time.h"
#include "pipeline/report_reason.h"
#include "world/map_changes.h"

namespace ninedot {

namespace {

/// A reading that is worse by more is excluded: as where a mirror image isn't refined (pose/full_solver.cpp).
constexpr double kExcluded_chi2 = 60;

TrackOptions track_options(const CameraModel& camera, const LocaliserOptions& options) {
  return {camera.fx_px, options.seeker.landmark, options.seeker.solver == Solver::kFull,
          options.seeker.detector.upright};
}

}  // namespace

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

PoseInformation covariance_in_world(const Matrix6d& covariance,
                                    const Transform<frame::World, frame::Landmark>& T_world_landmark) noexcept {
  PoseInformation turn = PoseInformation::Identity();
  turn.topLeftCorner<3, 3>() = T_world_landmark.rotation;
  return turn * covariance * turn.transpose();
}

Localiser::Localiser(const CameraModel& camera, const LocaliserOptions& options)
    : options_(options),
      lens_(std::make_unique<Lens>(camera, options.seeker, options.intrinsics, options.zoom), options.new_lenses),
      room_(std::make_unique<RoomMap>(options.seeker.landmark, options.map, options.trust.max_ambiguity)),
      track_(track_options(camera, options)),
      filter_(options.filter),
      row_time_(options.row_time, camera.height_px, RowTimeBelief::Untold::kIsGlobal) {}

void Localiser::take_newest_map() noexcept {
  std::unique_ptr<RoomMap> fresh = options_.new_maps != nullptr ? options_.new_maps->take() : nullptr;
  if (fresh == nullptr) return;
  EXPECTS(fresh->map.landmarks().size() == 1);
  if (!is_place_unchanged(mapped(), fresh->map.landmarks().front())) filter_.reset();
  std::swap(room_, fresh);
  options_.new_maps->give_back(std::move(fresh));
}

/// Through another lens nothing is where it was, nor by other rows.
void Localiser::begin_anew() noexcept {
  is_to_begin_anew_ = false;
  track_ = Track(track_options(lens_->seeker.camera(), options_));
  filter_.reset();
  next_guess_ = 0;
}

Result<std::size_t> Localiser::search(const Frame& frame) noexcept {
  track_.jump();
  WorkBudget& budget = lens_->seeker.budget();
  const std::size_t guess = std::exchange(next_guess_, 0);
  Result<std::size_t> chosen = fail(Errc::kNoLandmark, "nothing in the picture is a landmark");
  InlineVector<LandmarkObservation, 1 + Detector::kMaxGuesses> tried;
  const auto try_guess = [&](const LandmarkObservation& seen) {
    const auto is_seen = [&](const LandmarkObservation& other) {
      return is_same_reading(seen, other, options_.seeker.landmark);
    };
    if (chosen || std::ranges::any_of(tried, is_seen)) return true;
    (void)tried.try_push_back(seen);  // no more of them than guesses
    chosen = lens_->seeker.solve_guess(seen, track_);
    return chosen || budget.pixels > 0;
  };
  int charged = 0;
  const auto charge_search = [&] {
    budget.pixels += std::exchange(charged, pixels_of_search(options_.budget, budget));
    budget.pixels -= charged;
  };
  const auto found = lens_->seeker.detector().find_landmarks(frame.luma, budget);
  charge_search();
  if (!found) {
    if (const auto three = lens_->seeker.detector().three_dots()) lens_->seeker.show_three_dots(*three);
    return tl::unexpected<Error>(found.error());
  }
  const std::span<const LandmarkObservation> likely = *found;
  if (guess == 0 && (!try_guess(likely.front()) || chosen)) return chosen;
  NINEDOT_TRY(const auto unlikely, lens_->seeker.detector().find_more_landmarks(frame.luma, budget));
  charge_search();
  std::size_t begin_at = guess > 0 ? guess - 1 : 0;
  const std::size_t count =
      go_round(unlikely.size(), begin_at, [&](std::size_t rank) { return try_guess(unlikely[rank]); });
  if (count < unlikely.size()) next_guess_ = begin_at + 1;
  return chosen;
}

/// The camera in the world, by this landmark alone; and its track, which keeps what one picture leaves open: the mirror
/// image, and other numberings.
void Localiser::follow_in_world(const Frame& frame, const LandmarkFix& fix) noexcept {
  const MappedLandmark& mapped = this->mapped();
  const PoseEstimate& pose = fix.pose();
  if (fix.verdict == Reason::kNone) {
    fix_.world = WorldFix{fix.T_world_camera, fix.covariance_world, pose.ambiguity, {}};
    (void)fix_.world->used.try_push_back(fix.id);
  }
  LandmarkSighting sighting = fix.sighting;
  widen_by_scatter(sighting, options_.seeker.landmark);
  widen(sighting, lens_->seeker.row_motion().uncertainty, lens_->seeker.camera(), false);
  const JointMember member{&sighting, mapped.T_world_landmark, &mapped.covariance};
  InlineVector<WorldReading, PoseFilter::kMaxReadings> readings;
  const PoseCandidate& believed = fix.candidates.list[fix.chosen];
  const NumberingCosts costs =
      upright_costs(pose.T_landmark_camera.inverse(), options_.seeker.landmark, options_.seeker.detector.upright);
  const auto offer = [&](const PoseCandidate& candidate, std::size_t turn) {
    const double above_chi2 = candidate.chi2_above - believed.chi2_above + costs[turn] - costs[0];
    if (above_chi2 > kExcluded_chi2) return;
    const CameraFromLandmark T = candidate.pose.T_landmark_camera.inverse();
    (void)readings.try_push_back(
        {mapped.T_world_landmark * renumbered(T, static_cast<int>(turn)).inverse(), above_chi2, turn});
  };
  for (std::size_t turn = 0; turn < kRingDotCount; ++turn)
    for (std::size_t i = 0; i < fix.candidates.list.size(); ++i) {
      // The believed one comes first.
      const std::size_t index = i == 0 ? fix.chosen : i <= fix.chosen ? i - 1 : i;
      if (fix.candidates.list[index].refined) offer(fix.candidates.list[index], turn);
    }
  (void)filter_.take(frame.exposed_at(), {&member, 1}, readings.span());
}

/// By a pose that is right, be it that it is too uncertain to act on: the row time may be why.
void Localiser::learn_row_time(const LandmarkFix& fix, const TrackedPose& tracked) noexcept {
  if (!options_.learns_row_time || (fix.verdict != Reason::kNone && fix.verdict != Reason::kUncertain)) return;
  PictureRowTime picture(&tracked, options_.seeker.landmark, lens_->seeker.camera());
  picture.add(fix.sighting, fix.row_motion.sheet, mapped().T_world_landmark, nullptr, true);
  if (const auto evidence = picture.evidence(fix.T_world_camera))
    is_to_begin_anew_ |= row_time_.learn(*evidence) == RowTimeBelief::News::kContradicted;
}

void Localiser::add_calibration_error(LandmarkFix& fix) noexcept {
  if (!lens_->calibration_error.is_known()) return;
  PoseCandidate& candidate = fix.candidates.list[fix.chosen];
  const Matrix6d share = lens_->calibration_error.share_of(candidate);
  candidate.pose.covariance += share;
  fix.calibration_sigma_m = fix.calibration_sigma_world_m = position_sigma_m(share);
  calibration_share_ = covariance_in_world(share, mapped().T_world_landmark);
}

/// \param refused  why nobody may act on it, whatever its pose says; kNone: it is a landmark
void Localiser::add_fix(const PoseCandidates& candidates, std::size_t chosen, Reason refused) noexcept {
  const MappedLandmark& landmark = mapped();
  LandmarkFix fix;
  fix.id = landmark.id;
  fix.candidates = candidates;
  fix.chosen = chosen;
  set_sighting(fix, lens_->seeker.row_motion(), fix_.row_time.sigma_s, options_.seeker.landmark,
               lens_->seeker.camera());
  add_calibration_error(fix);
  const PoseEstimate& pose = fix.pose();
  fix.T_world_camera = landmark.T_world_landmark * pose.T_landmark_camera;
  fix.covariance_world = covariance_in_world(pose.covariance, landmark.T_world_landmark);
  fix.quality = pose_quality(pose);
  fix.verdict = refused != Reason::kNone ? refused : verdict_on(pose, options_.trust);
  fix.place_is_sure = is_place_sure(fix.candidates, chosen, fix.verdict, 0, options_.trust);
  fix_.reason = fix.verdict;
  (void)fix_.landmarks.try_push_back(fix);  // the only one
}

std::optional<FailedSearch> Localiser::failed_search() const noexcept {
  if (!has_search_failed_) return std::nullopt;
  return lens_->seeker.failed_search();
}

const Fix& Localiser::process(const Frame& frame) noexcept {
  const MonoTime begin = mono_now();
  take_newest_map();
  fix_.landmarks.clear();
  has_search_failed_ = false;
  fix_.world.reset();
  fix_.calibrated = options_.calibrated;
  fix_.solver = options_.seeker.solver;
  const LensInUse::Fit lens = lens_.fit_to(frame);
  if (lens != LensInUse::Fit::kSame || is_to_begin_anew_) begin_anew();
  if (lens != LensInUse::Fit::kNone)
    look_at(frame);
  else
    fix_.reason = Reason::kZoom, fix_.tracked = fix_.found = false, fix_.track.reset();
  fix_.process_time = mono_now() - begin;
  return fix_;
}

/// The whole path of a frame whose lens is there.
void Localiser::look_at(const Frame& frame) noexcept {
  fix_.row_time = row_time_.begin(frame);
  exposure_.begin(frame);
  lens_->seeker.begin(frame, options_.budget, fix_.row_time, exposure_.seconds());
  // Without tracking a frame's answer depends on that frame alone.
  if (!options_.tracking || track_.is_numbering_refuted()) track_.reset(), filter_.reset();
  const bool has_track = options_.tracking && track_.has_sighting() && next_guess_ == 0;
  Result<std::size_t> chosen = fail(Errc::kNoLandmark, "there is no track");
  if (has_track) chosen = lens_->seeker.follow_outlines(track_);
  if (has_track && !chosen) chosen = lens_->seeker.detect_near_track(track_);
  fix_.tracked = chosen.has_value();
  if (!chosen) chosen = search(frame);  // the landmark jumped, or what was near the track is not it

  WorkBudget& budget = lens_->seeker.budget();
  if (chosen) {
    add_fix(lens_->seeker.candidates(), *chosen, Reason::kNone);
    if (options_.tracking)
      exposure_.note(fix_.main().row_motion.sheet, fix_.main().candidates.list[*chosen].outlines,
                     lens_->seeker.camera());
    if (options_.seeker.solver == Solver::kFull) follow_in_world(frame, fix_.main());
  } else {
    track_.lose_pose(track_.has_sighting());
    fix_.reason = reason_of(chosen.error().code);
    const bool out_of_pixels = budget.pixels <= 0;
    // What was tried first comes last in the next frame.
    if (out_of_pixels && next_guess_ == 0) next_guess_ = 1;
    budget.is_overdrawn |= out_of_pixels;
    if (out_of_pixels || (fix_.reason == Reason::kNoLandmark && budget.is_overdrawn)) fix_.reason = Reason::kCrowded;
    if (lens_->seeker.misfit()) add_fix(*lens_->seeker.misfit(), 0, lens_->seeker.misfit_reason());
    has_search_failed_ = fix_.landmarks.empty();
  }
  fix_.track = filter_.at(frame.exposed_at());
  if (chosen && fix_.track) learn_row_time(fix_.main(), *fix_.track);
  if (fix_.track) fix_.track->covariance.topLeftCorner<6, 6>() += calibration_share_;
  fix_.found = track_.has_sighting() || !fix_.landmarks.empty();
  if (budget.is_overdrawn) ++frames_cut_;
  fix_.work = lens_.counts();
  fix_.work.frames_cut = frames_cut_;
}

}  // namespace ninedot
