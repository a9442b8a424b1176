#pragma once
/// What `ninedot map` starts from, beside pictures: which landmarks there may be, and which of their places count.
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "config/config.h"
#include "mapping/map_builder.h"
#include "mapping/recorded_sightings.h"
#include "world/landmark_map.h"

namespace ninedot {

struct MapStart {
  Config config;                     ///< with the landmarks that are looked for
  LandmarkMap known;                 ///< those, with the places that count alone
  std::vector<std::uint16_t> exact;  ///< ids, as MapBuilderOptions has them [1]
  std::vector<std::uint16_t> added;  ///< ids of the dictionary's that the configuration does not have, by id [1]
  double max_ambiguity = 0;          ///< of the configuration, for the second look [1]

  bool is_exact(std::uint16_t id) const noexcept;
  bool is_added(std::uint16_t id) const noexcept;
  /// Its place is given, with or without an uncertainty.
  bool is_given(std::uint16_t id) const noexcept;
  /// One of those that are given, which the others are relative to: the first of `exact`, if there is one. [1]
  std::uint16_t origin() const noexcept;
};

/// What recordings show, before any map is made of it.
struct SeenLandmarks {
  std::map<std::uint16_t, std::size_t> pictures;  ///< that show a landmark, by its id [1]
  std::set<std::uint16_t> together;               ///< ids of those that are in one with another landmark [1]
  std::vector<std::size_t> joining;               ///< of each recording: pictures that show two landmarks or more
  double speed_px_s = 0;                          ///< of the fastest landmark of a picture, the median
};

SeenLandmarks seen_in(std::span<const RecordedSightings> frames, std::size_t recordings);

/// \param config_path  of `config`, for errors
/// \param origins  ids of landmarks whose places are exact; or "measured": all that somebody measured; or "map": all
/// places that there are
/// \param with_dictionary  landmarks of the dictionary that the configuration does not have, and that none of its can
/// be taken for, are looked for as well
/// Throws StartupError(kWrongUsage): there is no such landmark, none has such a place, or there are less than two.
MapStart map_start(const Config& config, const std::string& config_path, const std::vector<std::string>& origins,
                   bool with_dictionary);

/// For the second look at the pictures: with the places of a first map the localiser foretells where landmarks are, and
/// finds those that are too small to be found unexpected. Those of the dictionary that hardly a picture shows are
/// looked for no more.
MapStart second_start(const MapStart& first, const BuiltMap& map, const SeenLandmarks& seen);

/// The file's landmarks, by id: those that were placed, and the configuration's others without a place, so that it may
/// take the place of the [[landmarks]] and none is lost.
std::vector<MappedLandmark> landmarks_of_map(const BuiltMap& map, const MapStart& start);

}  // namespace ninedot
