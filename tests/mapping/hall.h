#pragma once
/// A building of parallel corridors, joined at both ends, with landmarks on its walls and a camera that walks through:
/// sightings by projection, with noise as large as they say.
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/map_builder.h"
#include "mapping/recorded_sightings.h"
#include "world/landmark_map.h"

namespace ninedot::test {

struct HallOptions {
  std::size_t landmarks = 100;
  std::size_t frames = 1000;
  std::uint64_t seed = 1;
  double noise = 1;             ///< in the sightings' own sigmas [1]
  double wrong_identities = 0;  ///< share of the sightings that bear another landmark's id [1]
  double mirrored = 0.5;        ///< share of the sightings whose own pose is the mirror image, or nearly that [1]
  /// Of a rolling shutter: in every second sighting the camera has turned by so much, 1-sigma, and the sighting says
  /// so.
  double turn_sigma_rad = 0;
  std::uint16_t moved_id = 0;  ///< this sheet hangs 150 mm beside in the last `moved_share` of the pictures
  double moved_share = 0;      ///< [1]
};

struct Hall {
  std::vector<MappedLandmark> truth;  ///< ids 1, 2, ... along the camera's way
  std::vector<RecordedSightings> frames;
  std::size_t sightings() const;
  /// The landmarks without their places, as a configuration names them; the origin with it.
  LandmarkMap known(std::uint16_t origin) const;
};

Hall make_hall(const HallOptions& options);

/// How a map compares with the truth.
struct MapScore {
  std::size_t placed = 0;
  double rms_m = 0, worst_m = 0, rms_rad = 0;
  /// Errors over sigmas, rms over all landmarks and axes [1]: 1 is honest. Of whole landmarks: the root of the mean
  /// chi-square of six freedoms over six.
  double axes = 0, whole = 0;
};
MapScore score(const BuiltMap& map, std::span<const MappedLandmark> truth, std::uint16_t origin);

}  // namespace ninedot::test
