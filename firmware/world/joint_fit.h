#pragma once
/// The place of the camera that explains several sightings best: maximum likelihood over the rays of all their dots.
#include <array>
#include <span>

#include "geometry/optimiser_statistics.h"
#include "world/place_uncertainty.h"

namespace ninedot {

/// Landmarks in view that are joined.
inline constexpr std::size_t kMaxSightings = 16;

/// A sighting, and the place of the landmark that it is taken for.
struct JointMember {
  const LandmarkSighting* sighting = nullptr;
  WorldFromLandmark T_world_landmark;                ///< with the sighting's numbering of the dots
  const PoseCovariance* place_covariance = nullptr;  ///< null: the place is exact [m^2, m rad, rad^2]
};

struct JointFit {
  WorldFromCamera T_world_camera;
  SightingFit sum;                                 ///< of all members, there
  std::array<SightingFit, kMaxSightings> of_each;  ///< likewise, in the members' order
  OptimiserStatistics statistics;

  /// A finite chi^2 and six freedoms that are all seen.
  bool is_determined() const noexcept { return statistics.has_converged(); }
};

/// One member's equations, the uncertainty of its landmark's place eliminated.
/// Memory: none. Threads: pure.
SightingFit fit_of_member(const JointMember& member, const WorldFromCamera& T_world_camera,
                          const LandmarkGeometry& landmark) noexcept;

/// Gauss and Newton's method, damped where it must be (levenberg_marquardt.h), from one start: to the next crest of the
/// likelihood.
/// \param members  1..kMaxSightings (contract)
/// Memory: none. Threads: pure.
void fit_jointly(std::span<const JointMember> members, const WorldFromCamera& start, const LandmarkGeometry& landmark,
                 JointFit& fit) noexcept;

}  // namespace ninedot
