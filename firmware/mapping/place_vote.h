#pragma once
/// Which place of a landmark the most pictures agree about, where each may also be read as its mirror image.
#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "world/sighting_fit.h"

namespace ninedot {

/// (position [m], rotation vector [rad]), both in the axes of the frame that the place is in: p + position,
/// exp(rotation) R, as MappedLandmark::covariance is.
using PlaceStep = Eigen::Matrix<double, 6, 1>;
using PlaceCovariance = Eigen::Matrix<double, 6, 6>;

/// \param step  [m, rad]
WorldFromLandmark moved_by(const WorldFromLandmark& T_world_landmark, const PlaceStep& step) noexcept;
/// \return  [m, rad]: moved_by(from, step_between(from, to)) == to
PlaceStep step_between(const WorldFromLandmark& from, const WorldFromLandmark& to) noexcept;

/// What one picture says, read in one of its ways.
struct PlaceVote {
  std::size_t picture = 0;  ///< votes of one picture stand together, and one of them counts
  WorldFromLandmark place;
  PlaceCovariance covariance = PlaceCovariance::Zero();  ///< [m, rad]
  double penalty_chi2 = 0;  ///< by how much this way of reading is worse than the picture's best [1]
};

struct PlaceConsensus {
  WorldFromLandmark place;
  PlaceCovariance covariance = PlaceCovariance::Zero();  ///< of the mean of those that agree [m, rad]
  std::size_t agreeing = 0, pictures = 0;                ///< of how many that were asked
  /// By how much the best place of another opinion is worse [1]: near 0 the pictures leave open which it is.
  double lead_chi2 = 0;
};

/// The place with the least sum of squared distances, each in its own sigmas and cut off where the chi-square test with
/// kFalseAlarm rejects it; then the weighted mean of those that agree.
/// \param votes  not empty (contract); of many pictures a part is asked, evenly spread
/// Threads: pure. Memory: allocates.
PlaceConsensus find_consensus(std::span<const PlaceVote> votes);

}  // namespace ninedot
