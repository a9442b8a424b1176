#pragma once
/// How uncertain the places of a map are, relative to those that are given.
#include <optional>
#include <utility>
#include <vector>

#include "mapping/sighting_network.h"

namespace ninedot {

using LandmarkPair = std::pair<std::size_t, std::size_t>;  ///< indices

struct MapCovariance {
  std::vector<PlaceCovariance> places;  ///< of every landmark [m, rad]; zero where its place is given or unknown
  std::vector<PlaceCovariance> pairs;   ///< of the first's step with the second's, as asked [m, rad]
};

/// Inverts the normal equations of all sightings that count, cameras eliminated: blocks of the inverse alone, column by
/// column from a sparse factor, since the whole of it is dense (1000 landmarks: 290 MB).
/// \param pairs  sorted by their first landmark
/// \return  nothing: the sightings leave a placed landmark undetermined
/// Memory: allocates. Threads: one.
std::optional<MapCovariance> covariance_of(const SightingNetwork& network, const std::vector<LandmarkPair>& pairs);

}  // namespace ninedot
