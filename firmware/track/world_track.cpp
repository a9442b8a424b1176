#include "track/world_track.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "geometry/renumbered.h"

namespace ninedot {
namespace {

/// From one frame to the next a sheet moves before the camera by no more than this share of its distance: what
/// RoomLocaliser allows one that it has lost.
constexpr double kSamePlace = 0.1;
/// Those beside one that know the camera's place so many times less well agree with it wherever that one hangs.
constexpr double kNoWitness = 3;

double position_variance_m2(const PoseInformation& information) noexcept {
  const Eigen::LDLT<PoseInformation> ldlt(information);
  if (!(ldlt.info() == Eigen::Success && ldlt.vectorD().minCoeff() > 0)) return std::numeric_limits<double>::infinity();
  return ldlt.solve(PoseInformation::Identity()).topLeftCorner<3, 3>().trace();
}

}  // namespace

WorldPose WorldTrack::place(MonoTime exposed_at, std::span<const SightedLandmark> seen, const LandmarkMap& map,
                            WorldSolver& solver) noexcept {
  const auto forecast = filter_.forecast(exposed_at);
  WorldPrior prior, without;
  if (forecast) {
    prior = WorldPrior{.T_world_camera = forecast->T_world_camera,
                       .covariance = forecast->covariance,
                       .ambiguity = forecast->ambiguity};
    prior.doubted = doubted_in(seen);
    stand_.complete(prior, without);
  }
  const WorldPose world = solver.solve(seen, forecast ? &prior : nullptr);
  if (forecast)
    note_doubt(seen, world);
  else
    doubted_.reset();
  number(world, seen, map);
  verdict_ = FilterVerdict::kNothing;
  if (may_enter(world, seen, solver.max_ambiguity())) follow(exposed_at, world, seen, map);
  if (verdict_ == FilterVerdict::kStarted || verdict_ == FilterVerdict::kTaken)
    note_stand(exposed_at, world, prior, solver.landmark());
  return world;
}

/// \return  whether the track stands on that landmark
bool WorldTrack::stands_on(std::size_t landmark) const noexcept {
  return std::ranges::find(stands_on_, landmark) != stands_on_.end();
}

/// \return  index of the sighting that is in doubt [1]
std::optional<std::size_t> WorldTrack::doubted_in(std::span<const SightedLandmark> seen) const noexcept {
  if (!doubted_) return std::nullopt;
  // A black-and-white one is the one that is where it was.
  const double reach_m = kSamePlace * doubted_->p9_camera_m.norm();
  const auto at = std::ranges::find_if(seen, [&](const SightedLandmark& sighted) {
    return sighted.coded == doubted_->coded &&
           (sighted.coded ||
            (sighted.sighting.T_camera_landmark.translation_m - doubted_->p9_camera_m).norm() < reach_m);
  });
  if (at == seen.end()) return std::nullopt;
  return static_cast<std::size_t>(at - seen.begin());
}

/// A track that is not fed knows less from frame to frame; what contradicted it does not become true by that.
void WorldTrack::note_doubt(std::span<const SightedLandmark> seen, const WorldPose& world) noexcept {
  const auto is_used = [&](std::size_t i) { return world.sightings[i].use == SightingUse::kUsed; };
  if (const std::optional<std::size_t> at = doubted_in(seen)) {
    doubted_->p9_camera_m = seen[*at].sighting.T_camera_landmark.translation_m;
    if (world.is_valid() && is_used(*at)) doubted_.reset();
  } else if (doubted_ && !doubted_->coded) {
    doubted_.reset();  // out of sight nobody knows which one it is
  }
  if (seen.size() != 1 || world.verdict != WorldVerdict::kAmbiguous) return;
  const std::optional<std::size_t>& coded = seen[0].coded;
  const bool is_watched = coded && stands_on(*coded);
  if (!is_watched && !(is_used(0) && world.agrees_with_prior))
    doubted_ = Doubted{coded, seen[0].sighting.T_camera_landmark.translation_m};
}

void WorldTrack::reset() noexcept {
  filter_.reset();
  forget_landmarks();
}

void WorldTrack::forget_landmarks() noexcept {
  stand_.forget();
  stands_on_.clear();
  doubted_.reset();
}

/// The one that the newest place is made of, alone or beside others that say next to nothing of it. \return  index [1]
std::optional<std::size_t> WorldTrack::carrier(const WorldPose& world,
                                               const LandmarkGeometry& landmark) const noexcept {
  if (stands_on_.size() == 1) return stands_on_[0];
  InlineVector<PoseInformation, kMaxSightings> of_each;
  PoseInformation of_all = PoseInformation::Zero();
  for (const JointMember& member : used_.members) {
    (void)of_each.try_push_back(fit_of_member(member, world.T_world_camera, landmark).normal);
    of_all += of_each[of_each.size() - 1];
  }
  const double most_m2 = kNoWitness * kNoWitness * position_variance_m2(of_all);
  for (std::size_t i = 0; i < of_each.size() && i < stands_on_.size(); ++i)
    if (position_variance_m2(of_all - of_each[i]) > most_m2) return stands_on_[i];
  return std::nullopt;
}

void WorldTrack::note_stand(MonoTime exposed_at, const WorldPose& world, const WorldPrior& prior,
                            const LandmarkGeometry& landmark) noexcept {
  stands_on_.clear();
  for (const SightingVerdict& verdict : world.sightings)
    if (verdict.use == SightingUse::kUsed && verdict.landmark) (void)stands_on_.try_push_back(*verdict.landmark);
  // Against the one that the track stood on decided what was known without that.
  const bool is_against = world.is_contested && !stands_on(*prior.stands_on);
  const WorldPrior* before = is_against ? prior.without : verdict_ == FilterVerdict::kTaken ? &prior : nullptr;
  // Where its mirror image is open the track says which of the two it is.
  const Eigen::Vector3d at_m = filter_.forecast(exposed_at)->T_world_camera.translation_m;  // it has this frame
  const WorldReading& seen = *std::ranges::min_element(readings_, {}, [&](const WorldReading& reading) {
    return (reading.T_world_camera.translation_m - at_m).squaredNorm();
  });
  stand_.note(carrier(world, landmark), before, seen.T_world_camera, world.covariance);
}

void WorldTrack::number(const WorldPose& world, std::span<const SightedLandmark> seen,
                        const LandmarkMap& map) noexcept {
  used_.members.clear();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const SightingVerdict& verdict = world.sightings[i];
    if (verdict.use != SightingUse::kUsed || !verdict.landmark) continue;
    const MappedLandmark& landmark = map.landmarks()[*verdict.landmark];
    const int turn = static_cast<int>(verdict.turn);
    const LandmarkSighting& sighting = seen[i].sighting;
    used_.numbered[i] = {landmark.id, renumbered(sighting.T_camera_landmark, turn), renumbered(sighting.dots, turn),
                         sighting.turn_sigma_rad};
    (void)used_.members.try_push_back({&used_.numbered[i], landmark.T_world_landmark, &landmark.covariance});
  }
}

/// Beside what is valid: one coded landmark whose mirror image is open, for the track knows better, or will. Not one
/// that contradicts the track, unless that has just stood on it: a sheet does not move while it is looked at, and a
/// camera that was knocked does.
bool WorldTrack::may_enter(const WorldPose& world, std::span<const SightedLandmark> seen,
                           double max_ambiguity) const noexcept {
  if (used_.members.empty()) return false;
  if (world.is_valid()) return true;
  if (world.verdict != WorldVerdict::kAmbiguous || seen.size() != 1 || !seen[0].coded) return false;
  return world.astray <= max_ambiguity || stands_on(*seen[0].coded);
}

void WorldTrack::follow(MonoTime exposed_at, const WorldPose& world, std::span<const SightedLandmark> seen,
                        const LandmarkMap& map) noexcept {
  readings_.clear();
  (void)readings_.try_push_back({world.T_world_camera, 0, 0});
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const SightingVerdict& verdict = world.sightings[i];
    if (verdict.use != SightingUse::kUsed || !verdict.landmark || !seen[i].mirror) continue;
    const MappedLandmark& landmark = map.landmarks()[*verdict.landmark];
    const int turn = static_cast<int>(verdict.turn);
    const auto camera_by = [&](const CameraFromLandmark& T) {
      return landmark.T_world_landmark * renumbered(T, turn).inverse();
    };
    (void)readings_.try_push_back({camera_by(seen[i].sighting.T_camera_landmark), 0, 0});  // the best come first
    (void)readings_.try_push_back({camera_by(*seen[i].mirror), seen[i].mirror_chi2_above, 0});
  }
  verdict_ = filter_.take(exposed_at, used_.members.span(), readings_.span());
}

}  // namespace ninedot
