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
#include "world/foretold_ring.h"
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
// The first times all of the picture is searched: it may hang beside its place. Those that walls hide cost no more.
constexpr int kSearchedFor = 3;
// The camera's place foretells a landmark to what the window around it allows for, 1-sigma: so much of the ring's
// diameter, and for distant ones so many pixels (detect/search_area.cpp).
constexpr double kUsableOfRing = 0.3, kUsable_px = 16;
constexpr double kUsableRate_rad_s = 0.7;  // of the camera's turning: more is no better than knowing nothing
// From one frame to the next: a turn by 200 degrees per second at 35 frames, and what the distance of a landmark of
// dots of 2 px scatters by.
constexpr double kFarthestStep_rad = 0.1, kSameDistance = 0.1;
constexpr double kFarthest_m = 12, kLeastFacing = 0.15;  // cosine to the sheet's normal: 81 degrees

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

/// \param needs_place  LocaliserOptions'
Reason reason_of(WorldVerdict verdict, bool needs_place) noexcept {
  switch (verdict) {
    case WorldVerdict::kValid:
      return Reason::kNone;
    case WorldVerdict::kNothingSeen:
      return needs_place ? Reason::kUncertain : Reason::kNone;
    case WorldVerdict::kOnlyMoved:
      return Reason::kMoved;
    case WorldVerdict::kAmbiguous:
      return Reason::kAmbiguous;
    case WorldVerdict::kUndetermined:
      break;
  }
  return Reason::kPoseDegenerate;
}

/// What colours are read through, where the dots draw lines.
PictureMotion motion_in_picture(const OutlineState& outlines, const SheetMotion& sheet,
                                const CameraModel& camera) noexcept {
  const Smear smear(outlines);
  if (smear.parts == 1) return {};
  const Eigen::Vector3d& t_m = outlines.T_camera_landmark.translation_m;
  const Eigen::Vector2d px_s = sheet.ray_velocity(t_m, t_m).cwiseProduct(Eigen::Vector2d(camera.fx_px, camera.fy_px));
  return {smear.line_px.cast<float>(), (sheet.row_time_s * px_s).cast<float>()};
}

}  // namespace

RoomLocaliser::RoomLocaliser(const CameraModel& camera, const LocaliserOptions& options)
    : options_(without_map(options)),
      lens_(std::make_unique<Lens>(camera, with_map(options.seeker), options.intrinsics, options.zoom),
            options.new_lenses),
      room_(std::make_unique<RoomMap>(options.seeker.landmark, options.map, options.trust.max_ambiguity)),
      track_(options.filter),
      row_time_(options.row_time, camera.height_px, RowTimeBelief::Untold::kIsOpen),
      smeared_(camera) {}

/// A map that has come takes the place of the one before. Rings in view stay followed, and who they are stays known
/// where both maps have the sheet; the track begins anew where its landmarks hang elsewhere.
void RoomLocaliser::take_newest_map() noexcept {
  std::unique_ptr<RoomMap> fresh = options_.new_maps != nullptr ? options_.new_maps->take() : nullptr;
  if (fresh == nullptr) return;
  track_.forget_landmarks();
  if (!fresh->take_over(*room_)) {
    track_.reset();
    row_time_.forget_pictures();
  }
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

/// Through another lens nothing is where it was, nor by other rows.
void RoomLocaliser::begin_anew() noexcept {
  is_to_begin_anew_ = false;
  in_view_.clear();
  lost_.clear();
  track_.reset();
}

const LandmarkObservation* RoomLocaliser::last_observation() const noexcept {
  const auto shown = std::ranges::find_if(in_view_, [](const InView& l) { return l.track.has_sighting(); });
  return shown != in_view_.end() ? &shown->track.sighting() : nullptr;
}

std::optional<FailedSearch> RoomLocaliser::failed_search() const noexcept {
  if (!has_search_failed_) return std::nullopt;
  return lens_->seeker.failed_search();
}

/// What the track of the camera knows of its motion, if that is enough to tell where rows would have been.
std::optional<CameraTwist> RoomLocaliser::twist_at(MonoTime time) const noexcept {
  const auto tracked = track_.at(time);
  if (!tracked) return std::nullopt;
  const CameraTwist twist = twist_of(*tracked);
  if (twist.rate_sigma_rad_s > kUsableRate_rad_s) return std::nullopt;
  return twist;
}

/// The seeker's answer.
void RoomLocaliser::take_found(InView& landmark, std::size_t chosen) const noexcept {
  landmark.candidates = lens_->seeker.candidates();
  landmark.row_motion = lens_->seeker.row_motion();
  // By which their poses are at the middle row now, for who gives one of them to a track of its own.
  for (PoseCandidate& candidate : landmark.candidates.list)
    candidate.outlines.motion.translation_m_s = landmark.row_motion.sheet.translation_m_s;
  landmark.chosen = chosen;
  if (!landmark.is_followed) landmark.fits_black_and_white = lens_->seeker.fits_black_and_white();
}

/// Those that were in view in the frame before.
void RoomLocaliser::follow(const Frame& frame) noexcept {
  const auto& twist = smeared_.twist();
  lost_.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    InView& landmark = in_view_[i];
    if (landmark.track.is_numbering_refuted()) continue;
    if (twist && landmark.track.prior() != nullptr)
      landmark.track.foretell(twist->of_sheet_at(landmark.track.prior()->T_camera_landmark.translation_m));
    Result<std::size_t> chosen = lens_->seeker.follow_outlines(landmark.track);
    landmark.is_followed = chosen.has_value();
    if (!chosen) chosen = lens_->seeker.detect_near_track(landmark.track);
    if (!chosen && landmark.track.prior() != nullptr)
      chosen = lens_->seeker.look_at(landmark.track.expected_at(frame.exposed_at()), landmark.track);
    if (!chosen) {
      if (landmark.track.prior() != nullptr) (void)lost_.try_push_back(landmark);  // no more than were in view
      continue;
    }
    take_found(landmark, *chosen);
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
  const auto forecast = track_.forecast(frame.exposed_at());
  if (!forecast) return;
  const auto T_camera_world = forecast->T_world_camera.inverse();
  int looks = 0;
  for (std::size_t i = 0; i < room_->map.landmarks().size() && looks < kLooksPerFrame; ++i) {
    const MappedLandmark& landmark = room_->map.landmarks()[i];
    if (!landmark.has_place || room_->wait[i] > 0) continue;
    const Eigen::Vector3d p_m = T_camera_world * landmark.T_world_landmark.translation_m;
    if (!(p_m.z() > 0) || p_m.squaredNorm() > kFarthest_m * kFarthest_m) continue;
    const CameraFromLandmark T = T_camera_world * landmark.T_world_landmark;
    if (-T.rotation.col(1).dot(p_m.normalized()) < kLeastFacing) continue;
    const Eigen::Vector2d px = lens_->seeker.camera().pixel_from_normalised(p_m.hnormalized());
    if (!(px.x() > 0 && px.y() > 0 && px.x() < lens_->seeker.camera().width_px &&
          px.y() < lens_->seeker.camera().height_px))
      continue;
    const LandmarkForecast expected(T);
    // What a search came upon may be nobody yet, its colours too small to say who: the map says who should be there.
    const InView* there = in_view_at(expected.H_ray_plane);
    if (there != nullptr && (is_black_and_white(landmark.code) || !is_stranger(*there))) continue;
    const double usable = std::max(kUsableOfRing * 2 * options_.seeker.landmark.ring_radius_m / p_m.norm(),
                                   kUsable_px / lens_->seeker.camera().fx_px);
    if (!(foretold_ray_sigma(forecast->T_world_camera, forecast->covariance, landmark.T_world_landmark,
                             landmark.covariance, options_.seeker.landmark) < usable))
      continue;
    ++looks;
    const bool is_new = begin_where_expected(frame, T, i);
    room_->missed[i] =
        is_new ? std::uint8_t{0} : static_cast<std::uint8_t>(std::min(room_->missed[i] + 1, kMostMissed));
    room_->wait[i] = is_new ? std::uint8_t{0} : static_cast<std::uint8_t>(1U << room_->missed[i]);
    if (!is_new && room_->missed[i] <= kSearchedFor) frames_since_search_ = options_.search_every;
  }
}

/// By its dots, or where those are too small to be seen as such, by their outlines alone. \param map_index  of who
/// should be there
bool RoomLocaliser::begin_where_expected(const Frame& frame, const CameraFromLandmark& T_camera_landmark,
                                         std::size_t map_index) noexcept {
  if (in_view_.full()) return false;
  InView landmark;
  landmark.track = Track(track_options(lens_->seeker.camera(), options_));
  const bool is_coded = !is_black_and_white(room_->map.landmarks()[map_index].code);
  if (is_coded) landmark.expected = map_index;
  Result<std::size_t> chosen = fail(Errc::kNoLandmark, "there is nothing yet");
  const LandmarkForecast there(T_camera_landmark, is_coded ? ForecastNumbers::kCertain : ForecastNumbers::kForetold);
  if (const auto seen = lens_->seeker.detector().find_landmark_near(frame.luma, there, lens_->seeker.budget())) {
    if (const InView* known = in_view_at(seen->H_ray_plane); known != nullptr && !is_stranger(*known)) return false;
    chosen = lens_->seeker.solve_guess(*seen, landmark.track);
  }
  if (!chosen) chosen = lens_->seeker.look_at(T_camera_landmark, landmark.track);
  if (!chosen) return false;
  take_found(landmark, *chosen);
  // One sheet is in view once: as what it was found to be, and no more as the stranger that it was.
  const LandmarkForecast found(landmark.candidates.list[*chosen].pose.T_landmark_camera.inverse());
  if (InView* same = in_view_at(found.H_ray_plane)) {
    if (!is_stranger(*same)) return false;
    *same = in_view_[in_view_.size() - 1];
    in_view_.pop_back();
  }
  (void)in_view_.try_push_back(landmark);
  return true;
}

/// What is in view and not identified says nothing of where the camera is: others may.
bool RoomLocaliser::any_identified() const noexcept {
  return std::ranges::any_of(in_view_, [](const InView& landmark) { return landmark.identity.has_value(); });
}

void RoomLocaliser::look_everywhere(const Frame& frame) noexcept {
  frames_since_search_ = 0;
  const auto begin = [&](std::span<const LandmarkObservation> found) {
    for (const LandmarkObservation& seen : found)
      if (in_view_at(seen.H_ray_plane) == nullptr && !go_on_elsewhere(seen)) (void)begin_to_follow(seen);
  };
  if (const auto found = lens_->seeker.detector().find_all_landmarks(frame.luma, lens_->seeker.budget())) begin(*found);
  if (smeared_.is_smeared()) {
    const ImageView luma = smeared_.unblurred(frame.luma, lens_->seeker.camera());
    if (const auto found = lens_->seeker.detector().find_all_landmarks(luma, lens_->seeker.budget())) begin(*found);
  }
  if (!in_view_.empty()) return;
  // The search for one looks closer, and begins with the ring where P9 is spoiled.
  if (const auto found = lens_->seeker.detector().find_landmarks(frame.luma, lens_->seeker.budget())) begin(*found);
  has_search_failed_ = in_view_.empty();
}

/// The landmark in view there: the middle lies within its ring. Sheets don't overlap. Null: none.
RoomLocaliser::InView* RoomLocaliser::in_view_at(const Eigen::Matrix3d& H_ray_plane) noexcept {
  const Eigen::Vector2d middle = H_ray_plane.col(2).hnormalized();
  const auto at = std::ranges::find_if(in_view_, [&](const InView& landmark) {
    const PoseEstimate& pose = landmark.candidates.list[landmark.chosen].pose;
    const Eigen::Vector3d p_m = pose.T_landmark_camera.inverse().translation_m;
    return (p_m.hnormalized() - middle).norm() < options_.seeker.landmark.ring_radius_m / p_m.z();
  });
  return at != in_view_.end() ? &*at : nullptr;
}

/// Nobody knows who it is, nor who it should be.
bool RoomLocaliser::is_stranger(const InView& landmark) noexcept { return !landmark.identity && !landmark.expected; }

bool RoomLocaliser::begin_to_follow(const LandmarkObservation& seen) noexcept {
  if (in_view_.full()) return false;
  Track track(track_options(lens_->seeker.camera(), options_));
  const auto chosen = lens_->seeker.solve_guess(seen, track);
  if (!chosen) return false;
  InView landmark;
  landmark.track = track;
  take_found(landmark, *chosen);
  (void)in_view_.try_push_back(landmark);
  return true;
}

/// A camera that turns fast has every landmark elsewhere at once, and tells its motion by that: what was lost in this
/// frame goes on where one at its distance is found. That it is the same one its colours have to say.
bool RoomLocaliser::go_on_elsewhere(const LandmarkObservation& seen) noexcept {
  if (in_view_.full()) return false;
  const Eigen::Vector3d ray = seen.H_ray_plane.col(2).normalized();
  InView* nearest = nullptr;
  double least_rad = kFarthestStep_rad;
  for (InView& landmark : lost_) {
    const Eigen::Vector3d ray_before = landmark.track.prior()->T_camera_landmark.translation_m.normalized();
    const double step_rad = std::atan2(ray.cross(ray_before).norm(), ray.dot(ray_before));
    if (step_rad >= least_rad) continue;
    nearest = &landmark;
    least_rad = step_rad;
  }
  if (nearest == nullptr) return false;
  InView landmark = *nearest;
  const auto chosen = lens_->seeker.solve_guess(seen, landmark.track);
  if (!chosen) return false;
  landmark.is_followed = false;
  take_found(landmark, *chosen);
  const double before_m = nearest->track.prior()->T_camera_landmark.translation_m.norm();
  const double now_m = landmark.candidates.list[*chosen].pose.T_landmark_camera.translation_m.norm();
  if (std::abs(now_m - before_m) > kSameDistance * before_m) return false;
  landmark.is_fresh = false;
  (void)in_view_.try_push_back(landmark);
  *nearest = lost_[lost_.size() - 1];
  lost_.pop_back();
  return true;
}

/// Colours say which landmarks these are, and which dot is P1.
void RoomLocaliser::identify(const Frame& frame) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    InView& landmark = in_view_[i];
    const CameraFromLandmark T = landmark.candidates.list[landmark.chosen].pose.T_landmark_camera.inverse();
    const CameraFromLandmark T_shown = as_exposed(T, landmark.row_motion.sheet, lens_->seeker.camera());
    const PictureMotion motion = motion_in_picture(landmark.candidates.list[landmark.chosen].outlines,
                                                   landmark.row_motion.sheet, lens_->seeker.camera());
    // What was detected anew near there may be another sheet: its colours have to say that it is not.
    if (landmark.identity && landmark.identity->coded && !landmark.is_fresh && !landmark.is_followed) {
      ShownColours now;
      room_->codes.look(lens_->colours, frame, T_shown, motion, lens_->seeker.noise(), now);
      if (room_->codes.contradicts(*landmark.identity->coded, now)) {
        landmark.forget_identity();
        frames_since_search_ = options_.search_every;
      }
    }
    if (!landmark.identity) {
      if (!room_->codes.is_colourless())
        room_->codes.look(lens_->colours, frame, T_shown, motion, lens_->seeker.noise(), landmark.colours);
      landmark.identity = room_->codes.identify(landmark.colours, options_.trust.max_ambiguity);
      if (landmark.identity && landmark.identity->coded) number_by_code(frame, landmark);
      if (!landmark.identity && landmark.expected) {
        landmark.identity = room_->codes.confirm(*landmark.expected, landmark.colours, options_.trust.max_ambiguity);
        if (landmark.identity) landmark.track.know_numbering();  // as the map foretold it
      }
      // Only colours may look as no black dots do: a loudspeaker is no landmark because all of its holes are black.
      if (landmark.identity && !landmark.identity->coded && !landmark.fits_black_and_white) continue;
    } else if (landmark.identity->coded && !landmark.is_fresh) {
      if (!room_->codes.is_still(*landmark.identity->coded, lens_->colours, frame, T_shown, motion,
                                 lens_->seeker.noise(), landmark.doubt))
        continue;
    }
    if (kept != i) in_view_[kept] = landmark;
    ++kept;
  }
  while (in_view_.size() > kept) in_view_.pop_back();
}

void RoomLocaliser::number_by_code(const Frame& frame, InView& landmark) noexcept {
  const int turn = static_cast<int>(landmark.identity->turn);
  const LandmarkObservation seen = renumbered(landmark.track.sighting(), turn);
  landmark.candidates = renumbered(landmark.candidates, turn, lens_->seeker.camera(), options_.seeker.landmark);
  landmark.track.reset();
  landmark.track.know_numbering();
  landmark.track.see(seen);
  // The poses were finite before they were turned.
  landmark.chosen = landmark.track.take(landmark.candidates, frame.exposed_at()).value_or(0);
}

const Fix& RoomLocaliser::process(const Frame& frame) noexcept {
  const MonoTime begin = mono_now();
  take_newest_map();
  fix_.landmarks.clear();
  has_search_failed_ = false;
  fix_.world.reset();
  fix_.rejected.clear();
  fix_.disputed.clear();
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
void RoomLocaliser::look_at(const Frame& frame) noexcept {
  fix_.row_time = row_time_.begin(frame);
  smeared_.begin(frame, lens_->seeker.camera(), twist_at(frame.exposed_at()));
  lens_->seeker.begin(frame, kRoomBudget, fix_.row_time, smeared_.exposure_s(), smeared_.twist());

  if (options_.tracking) {
    follow(frame);
  } else {
    in_view_.clear();
    track_.reset();
  }
  fix_.tracked = !in_view_.empty();
  look_where_expected(frame);
  if (!any_identified() || ++frames_since_search_ >= options_.search_every) look_everywhere(frame);
  identify(frame);
  if (frames_since_search_ >= options_.search_every) {  // a sheet turned out to be another: so may be the view
    look_everywhere(frame);
    identify(frame);
  }
  for (const InView& landmark : in_view_)
    if (landmark.identity)
      smeared_.note(landmark.row_motion.sheet, landmark.candidates.list[landmark.chosen].outlines,
                    lens_->seeker.camera());
  const WorldVerdict verdict = place_in_world(frame);
  // What else comes into view tells where the camera is, or tells it better.
  if (verdict != WorldVerdict::kValid && verdict != WorldVerdict::kNothingSeen)
    frames_since_search_ = options_.search_every;

  WorkBudget& budget = lens_->seeker.budget();
  budget.is_overdrawn |= budget.pixels <= 0;
  if (budget.is_overdrawn) ++frames_cut_;
  fix_.found = !in_view_.empty();
  fix_.reason = !fix_.landmarks.empty() ? fix_.main().verdict
                : fix_.found            ? Reason::kNotIdentified
                : budget.is_overdrawn   ? Reason::kCrowded
                                        : Reason::kNoLandmark;
  if (fix_.reason == Reason::kNone) fix_.reason = reason_of(verdict, options_.needs_place);
  fix_.work = lens_.counts();
  fix_.work.frames_cut = frames_cut_;
}

}  // namespace ninedot
