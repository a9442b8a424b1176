#pragma once
/// A map of landmarks from pictures in which they appear together with their neighbours.
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/landmark.h"
#include "mapping/recorded_sightings.h"
#include "world/landmark_map.h"

namespace ninedot {

/// A sighting that does not fit the rest: a wrong identity, a sheet that hung elsewhere, or a bad picture.
struct DisagreeingSighting {
  std::size_t recording = 0;  ///< RecordedSightings::recording, an index [1]
  std::uint64_t frame = 0;
  std::uint16_t id = 0;
  double chi2_over_limit = 0;  ///< > 1: by so much more than kFalseAlarm of all true sightings have [1]
};

/// Two neighbours whose places relative to each other are the least certain of all neighbours'.
struct WeakestPair {
  std::uint16_t a = 0, b = 0;  ///< ids [1]
  double sigma_m = 0;          ///< of where one is, seen from the other: the root of the three variances' sum
};

struct BuiltMap {
  /// Those whose place is known, by id, with covariances relative to those that were given.
  std::vector<MappedLandmark> placed;
  std::vector<std::size_t> sighting_counts;         ///< of each of `placed`: how many of its sightings were used
  std::vector<std::vector<std::uint16_t>> islands;  ///< ids that are joined to each other, but not to the origin
  std::vector<std::uint16_t> unseen;                ///< ids [1] of landmarks that no picture shows beside another one
  std::vector<DisagreeingSighting> disagreeing;
  std::vector<std::uint16_t>
      disagreeing_surveys;  ///< ids whose surveyed place the pictures contradict; it was not used
  std::optional<WeakestPair> weakest;
  std::size_t frames = 0, sightings = 0;  ///< that were used
  /// Chi-square of the sightings used over its expectation [1]. Above 1 the pictures are worse than they say, and the
  /// covariances have been multiplied by it.
  double variance_factor = 1;
};

struct MapBuilderOptions {
  LandmarkGeometry geometry{};
  std::vector<std::uint16_t>
      exact;  ///< ids [1] of the origin, and of others whose places are exact. Not empty, or one is surveyed (contract)
  std::function<void(std::string_view what)> progress;  ///< a word about what is done, often; may be empty
};

/// Bundle adjustment over all sightings, cameras' places unknown. Sightings that disagree are found and left out by a
/// chi-square test that rejects one true sighting in a million (kFalseAlarm).
/// \param frames  of all recordings; those with less than two landmarks say nothing
/// \param known   the landmarks that there are, all of `exact` among them (contract). Of the others those whose
/// position
///                has an uncertainty are surveyed, and join in with it; what else is said of places is not used.
/// Memory: allocates. Threads: one, so that the same sightings give the same map to the last bit.
BuiltMap build_map(std::span<const RecordedSightings> frames, const LandmarkMap& known,
                   const MapBuilderOptions& options);

}  // namespace ninedot
