// From the landmarks in view to the camera's place in the world, and back: what the world says of each.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/renumbered.h"
#include "pipeline/fix_uncertainty.h"
#include "pipeline/picture_row_time.h"
#include "pipeline/room_localiser.h"
#include "pose/mirror_image.h"
#include "pose/renumbered_candidates.h"

namespace ninedot {
namespace {

/// A mirror image that is worse by more is excluded: as where it isn't refined (pose/full_solver.cpp).
constexpr double kExcluded_chi2 = 60;

/// Odds that one or the other is wrong.
double either(double a_odds, double b_odds) noexcept { return 1 - (1 - a_odds) * (1 - b_odds); }

/// Known well enough to be acted on: as each landmark's own pose has to be.
bool is_certain(const WorldPose& world, double nearest_m, const TrustLimits& limits) noexcept {
  return std::sqrt(world.covariance.topLeftCorner<3, 3>().trace()) <= limits.max_sigma_share * nearest_m;
}

}  // namespace

WorldVerdict RoomLocaliser::place_in_world(const Frame& frame) noexcept {
  InlineVector<SightedLandmark, kMaxSightings> sighted;
  InlineVector<std::size_t, kMaxSightings> which;  // index in in_view_
  // Where nothing is tracked nothing is ever known of the motion: every picture would be a first one.
  const bool may_move = options_.tracking && std::ranges::count_if(in_view_, [](const InView& landmark) {
                                               return landmark.identity.has_value();
                                             }) > 1;
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    const InView& landmark = in_view_[i];
    if (!landmark.identity) continue;
    const PoseCandidate& believed = landmark.candidates.list[landmark.chosen];
    SightedLandmark seen;
    seen.sighting = {0, believed.pose.T_landmark_camera.inverse(), believed.dots};
    widen_by_scatter(seen.sighting, options_.seeker.landmark);
    widen_by_smear(seen.sighting, believed.outlines, lens_->seeker.camera());
    seen.is_smeared = Smear(believed.outlines).parts > 1;
    widen(seen.sighting, landmark.row_motion.uncertainty, lens_->seeker.camera(), may_move);
    for (std::size_t other = 0; other < landmark.candidates.list.size(); ++other) {
      const PoseCandidate& mirror = landmark.candidates.list[other];
      const double above_chi2 = mirror.chi2_above - believed.chi2_above;
      // A rough one will do: whoever joins sightings fits it to their rays.
      if (other == landmark.chosen || above_chi2 > kExcluded_chi2) continue;
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
  WorldPose world = track_.place(frame.exposed_at(), sighted.span(), room_->map, room_->world);
  fix_.track = track_.at(frame.exposed_at());
  note_carriers();
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const SightedLandmark& seen : sighted)
    nearest_m = std::min(nearest_m, seen.sighting.T_camera_landmark.translation_m.norm());
  learn_row_time(world, sighted.span(), which.span());
  add_calibration_error(world);
  if (world.is_valid() && !is_certain(world, nearest_m, options_.trust)) world.verdict = WorldVerdict::kUndetermined;
  report_world(world, sighted.span(), which.span());
  tell_disputes();
  return world.verdict;
}

/// Whoever can measure where they hang has to know which.
void RoomLocaliser::tell_disputes() noexcept {
  const MovedLandmarks& moved = room_->world.moved();
  if (moved.disputed() == 0) return;
  for (std::size_t i = 0; i < room_->map.landmarks().size(); ++i)
    if (moved.is_disputed(i)) (void)fix_.disputed.try_push_back(room_->map.landmarks()[i].id);
}

/// By all whose landmarks have a place in the map, those that were left out as well: it may be why.
void RoomLocaliser::learn_row_time(const WorldPose& world, std::span<const SightedLandmark> sighted,
                                   std::span<const std::size_t> which) noexcept {
  if (!options_.learns_row_time) return;
  PictureRowTime picture(fix_.track ? &*fix_.track : nullptr, options_.seeker.landmark, lens_->seeker.camera());
  for (std::size_t i = 0; i < sighted.size(); ++i) {
    const SightingVerdict& verdict = world.sightings[i];
    const bool is_used = verdict.use == SightingUse::kUsed;
    // Of wrong numbers no row time makes sense.
    const bool is_known =
        is_used || (sighted[i].coded && verdict.use != SightingUse::kNoPlace && verdict.use != SightingUse::kMisread);
    if (!is_known || !verdict.landmark) continue;
    const MappedLandmark& mapped = room_->map.landmarks()[*verdict.landmark];
    const InView& landmark = in_view_[which[i]];
    const int turn = static_cast<int>(verdict.turn);
    const PoseCandidate& believed = landmark.candidates.list[landmark.chosen];
    const LandmarkSighting as_seen{mapped.id, renumbered(sighted[i].sighting.T_camera_landmark, turn),
                                   renumbered(believed.dots, turn)};
    picture.add(as_seen, landmark.row_motion.sheet, mapped.T_world_landmark, &mapped.covariance, is_used);
  }
  const auto evidence = picture.evidence(world.is_valid() ? std::optional(world.T_world_camera) : std::nullopt);
  const auto news = evidence ? row_time_.learn(*evidence) : RowTimeBelief::News::kNone;
  // What was followed was so by a wrong row time; and what was named as moved, where that explains it. A doubt that
  // comes by chance explains nothing, and a sheet that was moved stays named.
  is_to_begin_anew_ |= news == RowTimeBelief::News::kContradicted;
  if (news != RowTimeBelief::News::kNone && evidence->is_of_left_out) room_->world.forget_moved();
}

/// Once for all landmarks and all frames.
void RoomLocaliser::add_calibration_error(WorldPose& world) noexcept {
  if (!lens_->calibration_error.is_known()) return;
  const std::span<const JointMember> used = track_.used().members.span();
  if (!used.empty()) {
    calibration_share_ = lens_->calibration_error.share_of(used, world.T_world_camera);
    world.covariance += calibration_share_;
  }
  if (fix_.track) fix_.track->covariance.topLeftCorner<6, 6>() += calibration_share_;
}

/// What the track stands on, since it began.
void RoomLocaliser::note_carriers() noexcept {
  if (track_.verdict() == FilterVerdict::kStarted) std::ranges::fill(room_->carries_track, std::uint8_t{0});
  for (const std::size_t landmark : track_.newest_landmarks()) room_->carries_track[landmark] = 1;
}

/// What the picture says of each landmark, and of the camera in the world.
void RoomLocaliser::report_world(const WorldPose& world, std::span<const SightedLandmark> sighted,
                                 std::span<const std::size_t> which) noexcept {
  if (world.is_valid()) fix_.world = WorldFix{world.T_world_camera, world.covariance, world.ambiguity, {}};
  fix_.odds_of_other_places = world.verdict == WorldVerdict::kAmbiguous ? world.ambiguity : 0;
  for (std::size_t i = 0; i < sighted.size(); ++i) {
    const SightingVerdict& verdict = world.sightings[i];
    const std::optional<std::size_t> map_index = sighted[i].coded ? sighted[i].coded : verdict.landmark;
    if (!map_index) continue;
    InView& landmark = in_view_[which[i]];
    const std::uint16_t id = room_->map.landmarks()[*map_index].id;
    const bool is_used = world.is_valid() && verdict.use == SightingUse::kUsed;
    if (is_used) believe_world(landmark, *map_index, verdict.turn, world);
    if (is_used) (void)fix_.world->used.try_push_back(id);
    // Found so just now, or before: then it needs no place in the world to be named.
    const bool is_found_moved = world.is_valid() || (sighted[i].coded && room_->world.moved().is_moved(*map_index));
    if (is_found_moved && verdict.use == SightingUse::kRejected) (void)fix_.rejected.try_push_back(id);
    if (verdict.use == SightingUse::kMisread)
      landmark.forget_identity();
    else
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
  fix.candidates = turn == 0 ? landmark.candidates
                             : renumbered(landmark.candidates, turn, lens_->seeker.camera(), options_.seeker.landmark);
  fix.chosen = landmark.chosen;
  set_sighting(fix, landmark.row_motion, row_time_.now().sigma_s, options_.seeker.landmark, lens_->seeker.camera());
  PoseEstimate& pose = fix.candidates.list[fix.chosen].pose;
  const bool is_used = world.is_valid() && verdict.use == SightingUse::kUsed;
  if (lens_->calibration_error.is_known()) {
    const Matrix6d share = lens_->calibration_error.share_of(fix.candidates.list[fix.chosen]);
    pose.covariance += share;
    fix.calibration_sigma_m = position_sigma_m(share);
    fix.calibration_sigma_world_m = world.is_valid() ? position_sigma_m(calibration_share_) : fix.calibration_sigma_m;
  }
  // The world's odds have those of its landmarks' identities in them, where there is a track that tells otherwise.
  const double others_odds = landmark.identity->others_odds;
  pose.ambiguity = is_used ? std::max(world.ambiguity, others_odds) : either(pose.ambiguity, others_odds);
  fix.T_world_camera = world.is_valid() ? world.T_world_camera : mapped.T_world_landmark * pose.T_landmark_camera;
  fix.covariance_world =
      world.is_valid() ? world.covariance : covariance_in_world(pose.covariance, mapped.T_world_landmark);
  fix.quality = pose_quality(pose);
  fix.verdict = verdict_on(pose, options_.trust);
  fix.place_is_sure = is_place_sure(fix.candidates, fix.chosen, fix.verdict, others_odds, options_.trust);
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

}  // namespace ninedot
