#pragma once
/// Where the camera is in the world, from all landmarks in view together.
///
/// Maximum likelihood over the rays of all their dots, and not over their poses: a small landmark's pose, seen from
/// nearly in front, has a likelihood with two crests that are bent; averaged with another by its covariance it pulls
/// the answer to where no crest is. Over rays the likelihood is normal, one sum holds both crests of each landmark, and
/// what one leaves open the others decide. Where the rays' information is true the answer's covariance is the
/// Cramer-Rao bound.
///
/// Which sightings belong together is decided by hypotheses. One starts with a pair of sightings that agree (each crest
/// of the surer one is a start: a crest of all is near a crest of each), takes in all others that agree with it, and
/// is ended by a joint fit. A sighting agrees where its chi^2 of six freedoms against the rest is below a threshold;
/// what a hypothesis leaves out costs it that threshold. Odds between hypotheses are exp(-difference / 2).
///
/// A prior, the track's forecast, takes part in the odds and as a start. It does not enter the pose: the answer is what
/// this picture says, and a filter that made the prior may take it as a measurement.
#include <vector>

#include "world/hypothesis.h"
#include "world/moved_landmarks.h"
#include "world/prepared_map.h"
#include "world/world_pose.h"

namespace ninedot {

/// Memory: all at construction. Threads: one caller.
class WorldSolver {
 public:
  WorldSolver(std::vector<PlacedLandmark> landmarks, const LandmarkGeometry& landmark,
              const WorldOptions& options = {});
  const LandmarkGeometry& landmark() const noexcept { return landmark_; }

  /// \param seen  in one picture; at most kMaxSightings (contract) \param prior  null: nothing is known
  /// Remembers which landmarks were found moved.
  WorldPose solve(std::span<const SightedLandmark> seen, const WorldPrior* prior = nullptr) noexcept;

  double max_ambiguity() const noexcept { return options_.max_ambiguity; }  ///< above it a pose is not valid, 0..1
  const MovedLandmarks& moved() const noexcept { return moved_; }
  /// Whether a landmark was found moved stays known where it hangs unchanged in another map. \param before  the other
  /// map's \param landmark_before, landmark  index there and here [1]
  void carry_over(const WorldSolver& before, std::size_t landmark_before, std::size_t landmark) noexcept {
    moved_.carry_over(before.moved_, landmark_before, landmark);
  }
  /// Believes all landmarks again.
  void forget_moved() noexcept { moved_.clear(); }

 private:
  void start_from_coded(const Scene& scene) noexcept;
  bool add_anonymous(const Scene& scene) noexcept;
  bool start_without_coded(const Scene& scene, int sighted, HypothesisList& list) noexcept;
  WorldPose answer(const Scene& scene, bool is_complete) noexcept;
  void note_disputes(const Scene& scene) noexcept;
  void remember(const Scene& scene, const WorldPose& pose) noexcept;

  PreparedMap map_;
  LandmarkGeometry landmark_;
  WorldOptions options_;
  MovedLandmarks moved_;
  HypothesisList hypotheses_;
  HypothesisList pairs_;  ///< scratch: too large for the stack of a frame
};

}  // namespace ninedot
