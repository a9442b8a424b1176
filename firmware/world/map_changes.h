#pragma once
/// What one map says otherwise than another. Memory: none. Threads: pure.
#include <cstddef>
#include <optional>

#include "world/landmark_map.h"

namespace ninedot {

/// The same sheet in another map: the landmark of the same id and code. \return  index into its landmarks(); none: it
/// has no such sheet
std::optional<std::size_t> index_of_sheet(const LandmarkMap& map, const MappedLandmark& sheet) noexcept;

/// It hangs in the same place, which is known as well as before: to the last bit, as of a file that was not edited.
bool is_place_unchanged(const MappedLandmark& before, const MappedLandmark& now) noexcept;

/// How many landmarks, by their ids.
struct MapChanges {
  std::size_t added = 0, removed = 0;
  std::size_t moved = 0;      ///< their place is another one, or has become known or unknown
  std::size_t described = 0;  ///< in the same place, with another code or uncertainty

  bool operator==(const MapChanges&) const = default;
};
MapChanges map_changes(const LandmarkMap& before, const LandmarkMap& now) noexcept;

}  // namespace ninedot
