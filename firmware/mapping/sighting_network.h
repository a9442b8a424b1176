#pragma once
/// All sightings of all pictures, with numbers in place of identities, and the places that explain them.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/landmark.h"
#include "mapping/camera_fit.h"
#include "mapping/place_vote.h"
#include "mapping/recorded_sightings.h"
#include "world/landmark_map.h"

namespace ninedot {

/// A landmark of the map that is made.
struct NetworkLandmark {
  std::uint16_t id = 0;
  bool exact = false;                      ///< its place is given and stays
  std::optional<MappedLandmark> surveyed;  ///< given with an uncertainty
  bool placed = false;                     ///< `place` is known, at least nearly
  WorldFromLandmark place;
};

struct NetworkFrame {
  const RecordedSightings* source = nullptr;
  std::size_t first = 0, count = 0;  ///< its part of SightingNetwork::sightings
  bool placed = false;               ///< `camera` is known, at least nearly
  WorldFromCamera camera;
};

struct NetworkSighting {
  std::size_t frame = 0, landmark = 0;  ///< indices [1]
  const LandmarkSighting* seen = nullptr;
  OwnPoses own;          ///< not empty
  bool believed = true;  ///< false: it disagrees with the others
};

/// Memory: allocates; refers to the frames it was made from. Threads: one.
struct SightingNetwork {
  LandmarkGeometry geometry;
  std::vector<NetworkLandmark> landmarks;  ///< by id
  std::vector<NetworkFrame> frames;        ///< those that show two landmarks at least
  std::vector<NetworkSighting> sightings;  ///< those of a frame stand together

  std::span<NetworkSighting> of(const NetworkFrame& frame) noexcept {
    return std::span(sightings).subspan(frame.first, frame.count);
  }
  std::span<const NetworkSighting> of(const NetworkFrame& frame) const noexcept {
    return std::span(sightings).subspan(frame.first, frame.count);
  }

  /// Counts in the adjustment: believed, of a placed landmark in a placed frame.
  bool counts(const NetworkSighting& sighting) const noexcept {
    return sighting.believed && landmarks[sighting.landmark].placed && frames[sighting.frame].placed;
  }
  /// Of one sighting where everything stands now; infinite: a dot would lie behind the camera. [1]
  double chi2_of(const NetworkSighting& sighting) const noexcept;
  static int freedoms_of(const NetworkSighting& sighting) noexcept;  ///< twice its dots
};

/// \param map    what is known beforehand; sightings of other landmarks are left out
/// \param exact  ids [1] of landmarks whose places stay as they are; the origin is the first (contract: in `map`)
SightingNetwork make_network(std::span<const RecordedSightings> frames, const LandmarkMap& map,
                             std::span<const std::uint16_t> exact, const LandmarkGeometry& geometry);

/// Takes `placed` from every landmark that believed sightings do not join to one whose place is given, in two pictures
/// at least, over others or directly; and from every frame that is left with less than two landmarks.
void drop_unconnected(SightingNetwork& network);

}  // namespace ninedot
