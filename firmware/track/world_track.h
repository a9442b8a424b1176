#pragma once
/// From what each picture shows of the map's landmarks to where the camera is: each picture's place in the world,
/// decided with what the track lets expect, and the track that goes on by it.
#include <array>
#include <optional>
#include <span>

#include "track/lone_stand.h"
#include "track/pose_filter.h"
#include "world/landmark_map.h"
#include "world/world_solver.h"

namespace ninedot {

/// What a world pose is made of, each with its landmark's own numbering of the dots.
struct UsedSightings {
  std::array<LandmarkSighting, kMaxSightings> numbered;
  InlineVector<JointMember, kMaxSightings> members;  ///< each points into `numbered` and into the map

  UsedSightings() = default;
  UsedSightings(const UsedSightings&) = delete;
  UsedSightings& operator=(const UsedSightings&) = delete;
};

/// Memory: none beyond itself. Threads: one caller.
class WorldTrack {
 public:
  explicit WorldTrack(const PoseFilterOptions& options) noexcept : filter_(options) {}

  /// The next picture. A frame whose readings are open offers them all to the track.
  /// \param seen  in one picture; at most kMaxSightings (contract) \param map  of `solver`
  /// \return  by this picture; a track decides and does not enter
  WorldPose place(MonoTime exposed_at, std::span<const SightedLandmark> seen, const LandmarkMap& map,
                  WorldSolver& solver) noexcept;

  /// What the newest place is made of, and what became of it in the track: until the next one.
  const UsedSightings& used() const noexcept { return used_; }
  FilterVerdict verdict() const noexcept { return verdict_; }
  /// The landmarks of the newest picture that entered the track, by index [1].
  std::span<const std::size_t> newest_landmarks() const noexcept { return stands_on_.span(); }

  std::optional<TrackedPose> at(MonoTime time) const noexcept { return filter_.at(time); }  ///< see PoseFilter
  std::optional<PoseFilter::Forecast> forecast(MonoTime time) const noexcept { return filter_.forecast(time); }
  void reset() noexcept;
  /// The map is another one: landmarks are others, or have another index, and hang where they hung.
  void forget_landmarks() noexcept;

 private:
  void number(const WorldPose& world, std::span<const SightedLandmark> seen, const LandmarkMap& map) noexcept;
  bool stands_on(std::size_t landmark) const noexcept;
  std::optional<std::size_t> doubted_in(std::span<const SightedLandmark> seen) const noexcept;
  void note_doubt(std::span<const SightedLandmark> seen, const WorldPose& world) noexcept;
  bool may_enter(const WorldPose& world, std::span<const SightedLandmark> seen, double max_ambiguity) const noexcept;
  void follow(MonoTime exposed_at, const WorldPose& world, std::span<const SightedLandmark> seen,
              const LandmarkMap& map) noexcept;
  void note_stand(MonoTime exposed_at, const WorldPose& world, const WorldPrior& prior,
                  const LandmarkGeometry& landmark) noexcept;
  std::optional<std::size_t> carrier(const WorldPose& world, const LandmarkGeometry& landmark) const noexcept;

  PoseFilter filter_;
  LoneStand stand_;
  InlineVector<std::size_t, kMaxSightings> stands_on_;  // landmarks of the newest frame that entered the track
  UsedSightings used_;
  /// In view alone it was not where the track lets expect it.
  struct Doubted {
    std::optional<std::size_t> coded;  // see SightedLandmark
    Eigen::Vector3d p9_camera_m;       // where it was last
  };
  std::optional<Doubted> doubted_;
  InlineVector<WorldReading, PoseFilter::kMaxReadings> readings_;  // of the newest frame that was offered to the track
  FilterVerdict verdict_ = FilterVerdict::kNothing;
};

}  // namespace ninedot
