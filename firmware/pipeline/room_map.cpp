#include "pipeline/room_map.h"

#include <utility>

#include "world/map_changes.h"

namespace ninedot {

RoomMap::RoomMap(const LandmarkGeometry& landmark, LandmarkMap of, double max_ambiguity)
    : map(std::move(of)),
      codes(map),
      world(placed_landmarks(map), landmark, {.max_ambiguity = max_ambiguity}),
      missed(map.landmarks().size()),
      wait(map.landmarks().size()),
      carries_track(map.landmarks().size()) {}

bool RoomMap::take_over(const RoomMap& before) noexcept {
  bool track_stands = true;
  for (std::size_t old = 0; old < before.map.landmarks().size(); ++old) {
    const MappedLandmark& sheet = before.map.landmarks()[old];
    const std::optional<std::size_t> now = index_of_sheet(map, sheet);
    if (now && is_place_unchanged(sheet, map.landmarks()[*now])) {
      world.carry_over(before.world, old, *now);
      carries_track[*now] = before.carries_track[old];
    } else if (before.carries_track[old] != 0) {
      track_stands = false;
    }
  }
  return track_stands;
}

}  // namespace ninedot
