// Landmarks are followed one by one, each along its own track; what joins them is the world. The track of the camera in
// the world lets expect where further landmarks come into view.
#include "pipeline/room_localiser.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/renumbered.h"
#include "pipeline/report_reason.h"
#include "pose/mirror_image.h"
#include "pose/renumbered_candidates.h"
#include "world/landmark_codes.h"
#include "world/map_changes.h"

namespace ninedot {
namespace {

// What one frame may cost: four times the pixels of one landmark, of which sixteen at a usual distance take three
// quarters, and twice the guesses. The slowest picture takes as many times that of one landmark.
constexpr WorkBudget kRoomBudget{.regions = 4500, .guesses = 200, .second_guesses = 0, .pixels = 104'000};
constexpr int kLooksPerFrame = 3;  // where the map lets expect landmarks; each costs a window of the picture
// A landmark that is not where it should be (somebody stands before it) is looked for there after 1, 2, 4 .. frames.
constexpr int kMostMissed = 6;
// The camera's place foretells a landmark's to half of what the window around it allows for, at the nearest.
constexpr double kUsablePosition_m = 0.15, kUsableTurn_rad = 0.05;
constexpr double kUsableRate_rad_s = 0.7;  // of the camera's turning: more is no better than knowing nothing
constexpr double kFarthest_m = 12, kLeastFacing = 0.15;  // cosine to the sheet's normal: 81 degrees
/// A mirror image that is worse by more is excluded: as where it isn't refined (pose/full_solver.cpp).
constexpr double kExcluded_chi2 = 60;

TrackOptions track_options(const CameraModel& camera, const LocaliserOptions& options) {
  return {camera.fx_px, options.seeker.landmark, options.seeker.solver == Solver::kFull,
          options.seeker.detector.upright};
}

/// The map itself lies in RoomMap, where a newer one can take its place.
LocaliserOptions without_map(LocaliserOptions options) {
  options.map = {};
  return options;
}

SeekerOptions with_map(SeekerOptions options) {
  options.has_map = true;
  return options;
}

/// Odds that one or the other is wrong.
double either(double a_odds, double b_odds) noexcept { return 1 - (1 - a_odds) * (1 - b_odds); }

/// Known well enough to be acted on: as each landmark's own pose has to be.
bool is_certain(const WorldPose& world, double nearest_m, const TrustLimits& limits) noexcept {
  return std::sqrt(world.covariance.topLeftCorner<3, 3>().trace()) <= limits.max_sigma_share * nearest_m;
}

Reason reason_of(WorldVerdict verdict) noexcept {
  switch (verdict) {
    case WorldVerdict::kValid:
    case WorldVerdict::kNothingSeen:
      return Reason::kNone;
    case WorldVerdict::kOnlyMoved:
      return Reason::kMoved;
    case WorldVerdict::kAmbiguous:
      return Reason::kAmbiguous;
    case WorldVerdict::kUndetermined:
      break;
  }
  return Reason::kPoseDegenerate;
}

}  // namespace

RoomLocaliser::RoomLocaliser(const CameraModel& camera, const LocaliserOptions& options)
    : options_(without_map(options)),
      camera_(camera),
      seeker_(camera, with_map(options.seeker)),
      room_(std::make_unique<RoomMap>(camera, options.seeker.landmark, options.map, options.trust.max_ambiguity)),
      filter_(options.filter) {}

/// A map that has come takes the place of the one before. Rings in view stay followed, and who they are stays known
/// where both maps have the sheet; the track begins anew where its landmarks hang elsewhere.
void RoomLocaliser::take_newest_map() noexcept {
  std::unique_ptr<RoomMap> fresh = options_.new_maps != nullptr ? options_.new_maps->take() : nullptr;
  if (fresh == nullptr) return;
  if (!fresh->take_over(*room_)) filter_.reset();
  for (InView& landmark : in_view_) {
    landmark.expected.reset();
    // What one map calls black and white may have colours that the other one knows.
    if (landmark.identity && !landmark.identity->coded) landmark.identity.reset();
    if (!landmark.identity) continue;
    landmark.identity->coded = index_of_sheet(fresh->map, room_->map.landmarks()[*landmark.identity->coded]);
    if (!landmark.identity->coded) landmark.forget_identity();
  }
  std::swap(room_, fresh);
  options_.new_maps->give_back(std::move(fresh));
}

const LandmarkObservation* RoomLocaliser::last_observation() const noexcept {
  const auto shown = std::ranges::find_if(in_view_, [](const InView& l) { return l.track.has_sighting(); });
  return shown != in_view_.end() ? &shown->track.sighting() : nullptr;
}

/// What the track of the camera knows of its motion, if that is enough to tell where rows would have been.
std::optional<CameraTwist> RoomLocaliser::twist_at(MonoTime time) const noexcept {
  const auto tracked = filter_.at(time);
  if (!tracked) return std::nullopt;
  const double rate_sigma_rad_s = std::sqrt(tracked->covariance.diagonal().tail<3>().sum());
  if (rate_sigma_rad_s > kUsableRate_rad_s) return std::nullopt;
  return CameraTwist{tracked->motion.angular_velocity_rad_s,
                     tracked->motion.T_world_camera.rotation.transpose() * tracked->motion.velocity_m_s,
                     rate_sigma_rad_s};
}

/// Those that were in view in the frame before.
void RoomLocaliser::follow(const Frame& frame) noexcept {
  const auto twist = twist_at(frame.exposed_at());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    InView& landmark = in_view_[i];
    if (landmark.track.is_numbering_refuted()) continue;
    if (twist && landmark.track.prior() != nullptr)
      landmark.track.foretell(twist->of_sheet_at(landmark.track.prior()->T_camera_landmark.translation_m));
    Result<std::size_t> chosen = seeker_.follow_outlines(frame, landmark.track);
    landmark.is_followed = chosen.has_value();
    if (!chosen) chosen = seeker_.detect_near_track(frame, landmark.track);
    if (!chosen && landmark.track.prior() != nullptr)
      chosen = seeker_.look_at(frame, landmark.track.expected_at(frame.exposed_at()), landmark.track);
    if (!chosen) continue;
    landmark.candidates = seeker_.candidates();
    landmark.row_motion = seeker_.row_motion();
    landmark.chosen = *chosen;
    landmark.is_fresh = false;
    if (kept != i) in_view_[kept] = landmark;
    ++kept;
  }
  // Where one is lost the view has changed: others may have come.
  if (kept < in_view_.size()) frames_since_search_ = options_.search_every;
  while (in_view_.size() > kept) in_view_.pop_back();
}

/// Where the track of the camera in the world lets the map's landmarks be in this picture.
void RoomLocaliser::look_where_expected(const Frame& frame) noexcept {
  for (std::uint8_t& frames : room_->wait) frames = static_cast<std::uint8_t>(frames > 0 ? frames - 1 : 0);
  const auto forecast = filter_.forecast(frame.exposed_at());
  if (!forecast || forecast->covariance.topLeftCorner<3, 3>().trace() > kUsablePosition_m * kUsablePosition_m ||
      forecast->covariance.bottomRightCorner<3, 3>().trace() > kUsableTurn_rad * kUsableTurn_rad)
    return;
  const auto T_camera_world = forecast->T_world_camera.inverse();
  int looks = 0;
  for (std::size_t i = 0; i < room_->map.landmarks().size() && looks < kLooksPerFrame; ++i) {
    const MappedLandmark& landmark = room_->map.landmarks()[i];
    if (!landmark.has_place || room_->wait[i] > 0) continue;
    const Eigen::Vector3d p_m = T_camera_world * landmark.T_world_landmark.translation_m;
    if (!(p_m.z() > 0) || p_m.squaredNorm() > kFarthest_m * kFarthest_m) continue;
    const CameraFromLandmark T = T_camera_world * landmark.T_world_landmark;
    if (-T.rotation.col(1).dot(p_m.normalized()) < kLeastFacing) continue;
    const Eigen::Vector2d px = camera_.pixel_from_normalised(p_m.hnormalized());
    if (!(px.x() > 0 && px.y() > 0 && px.x() < camera_.width_px && px.y() < camera_.height_px)) continue;
    const LandmarkForecast expected(T);
    if (is_known(expected.H_ray_plane)) continue;
    ++looks;
    const bool is_new = begin_where_expected(frame, T, i);
    room_->missed[i] =
        is_new ? std::uint8_t{0} : static_cast<std::uint8_t>(std::min(room_->missed[i] + 1, kMostMissed));
    room_->wait[i] = is_new ? std::uint8_t{0} : static_cast<std::uint8_t>(1U << room_->missed[i]);
  }
}

/// By its dots, or where those are too small to be seen as such, by their outlines alone. \param map_index  of who
/// should be there
bool RoomLocaliser::begin_where_expected(const Frame& frame, const CameraFromLandmark& T_camera_landmark,
                                         std::size_t map_index) noexcept {
  if (in_view_.full()) return false;
  InView landmark;
  landmark.track = Track(track_options(camera_, options_));
  const bool is_coded = !is_black_and_white(room_->map.landmarks()[map_index].code);
  if (is_coded) landmark.expected = map_index;
  Result<std::size_t> chosen = fail(Errc::kNoLandmark, "there is nothing yet");
  const LandmarkForecast there(T_camera_landmark, is_coded ? ForecastNumbers::kCertain : ForecastNumbers::kForetold);
  if (const auto seen = seeker_.detector().find_landmark_near(frame.luma, there, seeker_.budget())) {
    if (is_known(seen->H_ray_plane)) return false;
    chosen = seeker_.solve_guess(frame, *seen, landmark.track);
  }
  if (!chosen) chosen = seeker_.look_at(frame, T_camera_landmark, landmark.track);
  if (!chosen) return false;
  landmark.candidates = seeker_.candidates();
  landmark.row_motion = seeker_.row_motion();
  landmark.chosen = *chosen;
  (void)in_view_.try_push_back(landmark);
  return true;
}

void RoomLocaliser::look_everywhere(const Frame& frame) noexcept {
  frames_since_search_ = 0;
  const auto begin = [&](std::span<const LandmarkObservation> found) {
    for (const LandmarkObservation& seen : found)
      if (!is_known(seen.H_ray_plane)) (void)begin_to_follow(frame, seen);
  };
  if (const auto found = seeker_.detector().find_all_landmarks(frame.luma, seeker_.budget())) begin(*found);
  if (!in_view_.empty()) return;
  // The search for one looks closer, and begins with the ring where P9 is spoiled.
  if (const auto found = seeker_.detector().find_landmarks(frame.luma, seeker_.budget())) begin(*found);
}

/// Whether a landmark there is in view already: its middle lies within the ring of one that is. Sheets don't overlap.
bool RoomLocaliser::is_known(const Eigen::Matrix3d& H_ray_plane) const noexcept {
  const Eigen::Vector2d middle = H_ray_plane.col(2).hnormalized();
  return std::ranges::any_of(in_view_, [&](const InView& landmark) {
    const PoseEstimate& pose = landmark.candidates.list[landmark.chosen].pose;
    const Eigen::Vector3d p_m = pose.T_landmark_camera.inverse().translation_m;
    return (p_m.hnormalized() - middle).norm() < options_.seeker.landmark.ring_radius_m / p_m.z();
  });
}

bool RoomLocaliser::begin_to_follow(const Frame& frame, const LandmarkObservation& seen) noexcept {
  if (in_view_.full()) return false;
  Track track(track_options(camera_, options_));
  const auto chosen = seeker_.solve_guess(frame, seen, track);
  if (!chosen) return false;
  InView landmark;
  landmark.track = track;
  landmark.candidates = seeker_.candidates();
  landmark.row_motion = seeker_.row_motion();
  landmark.chosen = *chosen;
  (void)in_view_.try_push_back(landmark);
  return true;
}

/// Colours say which landmarks these are, and which dot is P1.
void RoomLocaliser::identify(const Frame& frame) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    InView& landmark = in_view_[i];
    const CameraFromLandmark T = landmark.candidates.list[landmark.chosen].pose.T_landmark_camera.inverse();
    const CameraFromLandmark T_shown = as_exposed(T, landmark.row_motion.sheet, camera_);
    // What was detected anew near there may be another sheet: its colours have to say that it is not.
    if (landmark.identity && landmark.identity->coded && !landmark.is_fresh && !landmark.is_followed) {
      ShownColours now;
      room_->codes.look(frame, T_shown, seeker_.noise(), now);
      if (room_->codes.contradicts(*landmark.identity->coded, now)) {
        landmark.forget_identity();
        frames_since_search_ = options_.search_every;
      }
    }
    if (!landmark.identity) {
      if (!room_->codes.is_colourless()) room_->codes.look(frame, T_shown, seeker_.noise(), landmark.colours);
      landmark.identity = room_->codes.identify(landmark.colours, options_.trust.max_ambiguity);
      if (landmark.identity && landmark.identity->coded) number_by_code(frame, landmark);
      if (!landmark.identity && landmark.expected) {
        landmark.identity = room_->codes.confirm(*landmark.expected, landmark.colours, options_.trust.max_ambiguity);
        if (landmark.identity) landmark.track.know_numbering();  // as the map foretold it
      }
    } else if (landmark.identity->coded && !landmark.is_fresh) {
      if (!room_->codes.is_still(*landmark.identity->coded, frame, T_shown, seeker_.noise(), landmark.doubt)) continue;
    }
    if (kept != i) in_view_[kept] = landmark;
    ++kept;
  }
  while (in_view_.size() > kept) in_view_.pop_back();
}

void RoomLocaliser::number_by_code(const Frame& frame, InView& landmark) noexcept {
  const int turn = static_cast<int>(landmark.identity->turn);
  const LandmarkObservation seen = renumbered(landmark.track.sighting(), turn);
  landmark.candidates = renumbered(landmark.candidates, turn, camera_, options_.seeker.landmark);
  landmark.track.reset();
  landmark.track.know_numbering();
  landmark.track.see(seen);
  // The poses were finite before they were turned.
  landmark.chosen = landmark.track.take(landmark.candidates, frame.exposed_at()).value_or(0);
}

WorldVerdict RoomLocaliser::place_in_world(const Frame& frame) noexcept {
  InlineVector<SightedLandmark, kMaxSightings> sighted;
  InlineVector<std::size_t, kMaxSightings> which;  // index in in_view_
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    const InView& landmark = in_view_[i];
    if (!landmark.identity) continue;
    const PoseCandidate& believed = landmark.candidates.list[landmark.chosen];
    SightedLandmark seen;
    seen.sighting = {0, believed.pose.T_landmark_camera.inverse(), believed.dots};
    widen_by_scatter(seen.sighting, options_.seeker.landmark);
    widen(seen.sighting, landmark.row_motion.uncertainty, camera_);
    for (std::size_t other = 0; other < landmark.candidates.list.size(); ++other) {
      const PoseCandidate& mirror = landmark.candidates.list[other];
      const double above_chi2 = mirror.chi2_above - believed.chi2_above;
      if (other == landmark.chosen || !mirror.refined || above_chi2 > kExcluded_chi2) continue;
      seen.mirror = mirror.pose.T_landmark_camera.inverse();
      seen.mirror_chi2_above = above_chi2;
    }
    seen.coded = landmark.identity->coded;
    seen.others_odds = landmark.identity->others_odds;
    if (!seen.coded)
      seen.numbering_costs =
          upright_costs(seen.sighting.T_camera_landmark, options_.seeker.landmark, options_.seeker.detector.upright);
    (void)sighted.try_push_back(seen);  // as many as are in view
    (void)which.try_push_back(i);
  }
  const auto forecast = filter_.forecast(frame.exposed_at());
  const WorldPrior prior = forecast ? WorldPrior{forecast->T_world_camera, forecast->covariance} : WorldPrior{};
  WorldPose world = room_->world.solve(sighted.span(), forecast ? &prior : nullptr);
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const SightedLandmark& seen : sighted)
    nearest_m = std::min(nearest_m, seen.sighting.T_camera_landmark.translation_m.norm());
  follow_in_world(frame, world, sighted.span());
  if (world.is_valid() && !is_certain(world, nearest_m, options_.trust)) world.verdict = WorldVerdict::kUndetermined;
  report_world(world, sighted.span(), which.span());
  return world.verdict;
}

/// The track of the camera: by what the world pose is made of. A frame whose readings are open offers them all.
void RoomLocaliser::follow_in_world(const Frame& frame, const WorldPose& world,
                                    std::span<const SightedLandmark> sighted) noexcept {
  std::array<LandmarkSighting, kMaxSightings> numbered;
  InlineVector<JointMember, kMaxSightings> used;
  InlineVector<WorldReading, PoseFilter::kMaxReadings> readings;
  (void)readings.try_push_back({world.T_world_camera, 0, 0});
  for (std::size_t i = 0; i < sighted.size(); ++i) {
    const SightingVerdict& verdict = world.sightings[i];
    if (verdict.use != SightingUse::kUsed || !verdict.landmark) continue;
    const MappedLandmark& landmark = room_->map.landmarks()[*verdict.landmark];
    const int turn = static_cast<int>(verdict.turn);
    numbered[i] = {landmark.id, renumbered(sighted[i].sighting.T_camera_landmark, turn),
                   renumbered(sighted[i].sighting.dots, turn)};
    (void)used.try_push_back({&numbered[i], landmark.T_world_landmark, &landmark.covariance});
    if (!sighted[i].mirror) continue;
    const auto camera_by = [&](const CameraFromLandmark& T) {
      return landmark.T_world_landmark * renumbered(T, turn).inverse();
    };
    (void)readings.try_push_back({camera_by(sighted[i].sighting.T_camera_landmark), 0, 0});  // the best come first
    (void)readings.try_push_back({camera_by(*sighted[i].mirror), sighted[i].mirror_chi2_above, 0});
  }
  // One coded landmark whose mirror image is open: the track knows better, or will.
  const bool is_known = world.is_valid() || (world.verdict == WorldVerdict::kAmbiguous && used.size() == 1 &&
                                             sighted.size() == 1 && sighted[0].coded);
  if (is_known && !used.empty()) note_carriers(world, filter_.take(frame.exposed_at(), used.span(), readings.span()));
  fix_.track = filter_.at(frame.exposed_at());
}

/// What the track stands on.
void RoomLocaliser::note_carriers(const WorldPose& world, FilterVerdict verdict) noexcept {
  if (verdict == FilterVerdict::kStarted) std::ranges::fill(room_->carries_track, std::uint8_t{0});
  if (verdict != FilterVerdict::kStarted && verdict != FilterVerdict::kTaken) return;
  for (const SightingVerdict& sighting : world.sightings)
    if (sighting.use == SightingUse::kUsed && sighting.landmark) room_->carries_track[*sighting.landmark] = 1;
}

/// What the picture says of each landmark, and of the camera in the world.
void RoomLocaliser::report_world(const WorldPose& world, std::span<const SightedLandmark> sighted,
                                 std::span<const std::size_t> which) noexcept {
  if (world.is_valid()) fix_.world = WorldFix{world.T_world_camera, world.covariance, world.ambiguity, {}, {}};
  for (std::size_t i = 0; i < sighted.size(); ++i) {
    const SightingVerdict& verdict = world.sightings[i];
    const std::optional<std::size_t> map_index = sighted[i].coded ? sighted[i].coded : verdict.landmark;
    if (!map_index) continue;
    InView& landmark = in_view_[which[i]];
    const std::uint16_t id = room_->map.landmarks()[*map_index].id;
    const bool is_used = world.is_valid() && verdict.use == SightingUse::kUsed;
    if (is_used) believe_world(landmark, *map_index, verdict.turn, world);
    if (is_used) (void)fix_.world->used.try_push_back(id);
    if (world.is_valid() && verdict.use == SightingUse::kRejected) (void)fix_.world->rejected.try_push_back(id);
    add_fix(landmark, *map_index, verdict, world);
  }
}

/// Of a landmark's two planar solutions the one that the world's pose says.
void RoomLocaliser::believe_world(InView& landmark, std::size_t map_index, std::size_t turn,
                                  const WorldPose& world) noexcept {
  const CameraFromLandmark expected = renumbered(
      world.T_world_camera.inverse() * room_->map.landmarks()[map_index].T_world_landmark, -static_cast<int>(turn));
  const auto turn_rad = [&](const PoseCandidate& candidate) {
    return angle_between_rad(expected, candidate.pose.T_landmark_camera.inverse());
  };
  auto& list = landmark.candidates.list;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].refined && turn_rad(list[i]) < turn_rad(list[landmark.chosen])) landmark.chosen = i;
  landmark.track.believe(landmark.candidates, landmark.chosen);
}

void RoomLocaliser::add_fix(const InView& landmark, std::size_t map_index, const SightingVerdict& verdict,
                            const WorldPose& world) noexcept {
  const MappedLandmark& mapped = room_->map.landmarks()[map_index];
  const int turn = static_cast<int>(verdict.turn);
  LandmarkFix fix;
  fix.id = mapped.id;
  fix.candidates =
      turn == 0 ? landmark.candidates : renumbered(landmark.candidates, turn, camera_, options_.seeker.landmark);
  fix.chosen = landmark.chosen;
  PoseEstimate& pose = fix.candidates.list[fix.chosen].pose;
  const bool is_used = world.is_valid() && verdict.use == SightingUse::kUsed;
  widen(pose, landmark.row_motion.uncertainty, camera_);
  pose.ambiguity = either(is_used ? world.ambiguity : pose.ambiguity, landmark.identity->others_odds);
  fix.sighting = {mapped.id, pose.T_landmark_camera.inverse(), fix.candidates.list[fix.chosen].dots};
  fix.T_world_camera = world.is_valid() ? world.T_world_camera : mapped.T_world_landmark * pose.T_landmark_camera;
  fix.covariance_world = world.is_valid() ? world.covariance : covariance_in_world(pose, mapped.T_world_landmark);
  fix.quality = pose_quality(pose);
  fix.verdict = verdict_on(pose, true, options_.trust);
  (void)fix_.landmarks.try_push_back(fix);
  // The one that counts comes first: one that may be acted on, the nearest or surest of those.
  const auto rank_m2 = [&](const LandmarkFix& f) {
    return options_.main_landmark == MainLandmark::kSurest ? f.pose().covariance.topLeftCorner<3, 3>().trace()
                                                           : f.pose().T_landmark_camera.translation_m.squaredNorm();
  };
  const auto comes_before = [&](const LandmarkFix& a, const LandmarkFix& b) {
    const bool a_is_valid = a.verdict == Reason::kNone, b_is_valid = b.verdict == Reason::kNone;
    return a_is_valid != b_is_valid ? a_is_valid : rank_m2(a) < rank_m2(b);
  };
  const std::size_t last = fix_.landmarks.size() - 1;
  if (last > 0 && comes_before(fix_.landmarks[last], fix_.landmarks[0]))
    std::swap(fix_.landmarks[0], fix_.landmarks[last]);
}

const Fix& RoomLocaliser::process(const Frame& frame) noexcept {
  const MonoTime begin = mono_now();
  take_newest_map();
  fix_.landmarks.clear();
  fix_.world.reset();
  fix_.calibrated = options_.calibrated;
  fix_.solver = options_.seeker.solver;
  seeker_.begin(frame, kRoomBudget, twist_at(frame.exposed_at()));

  if (options_.tracking) {
    follow(frame);
  } else {
    in_view_.clear();
    filter_.reset();
  }
  fix_.tracked = !in_view_.empty();
  look_where_expected(frame);
  if (in_view_.empty() || ++frames_since_search_ >= options_.search_every) look_everywhere(frame);
  identify(frame);
  if (frames_since_search_ >= options_.search_every) {  // a sheet turned out to be another: so may be the view
    look_everywhere(frame);
    identify(frame);
  }
  const WorldVerdict verdict = place_in_world(frame);

  WorkBudget& budget = seeker_.budget();
  budget.is_overdrawn |= budget.pixels <= 0;
  if (budget.is_overdrawn) ++frames_cut_;
  fix_.found = !in_view_.empty();
  fix_.reason = !fix_.landmarks.empty() ? fix_.main().verdict
                : fix_.found            ? Reason::kNotIdentified
                : budget.is_overdrawn   ? Reason::kCrowded
                                        : Reason::kNoLandmark;
  if (fix_.reason == Reason::kNone) fix_.reason = reason_of(verdict);
  fix_.work = seeker_.detector().counts();
  fix_.work.frames_cut = frames_cut_;
  fix_.process_time = mono_now() - begin;
  return fix_;
}

}  // namespace ninedot
