#include "world/map_changes.h"

namespace ninedot {
namespace {

bool is_same_place(const MappedLandmark& a, const MappedLandmark& b) noexcept {
  return a.has_place == b.has_place && a.T_world_landmark.translation_m == b.T_world_landmark.translation_m &&
         a.T_world_landmark.rotation == b.T_world_landmark.rotation;
}

}  // namespace

std::optional<std::size_t> index_of_sheet(const LandmarkMap& map, const MappedLandmark& sheet) noexcept {
  const MappedLandmark* found = map.find(sheet.id);
  if (found == nullptr || found->code != sheet.code) return std::nullopt;
  return static_cast<std::size_t>(found - map.landmarks().data());
}

bool is_place_unchanged(const MappedLandmark& before, const MappedLandmark& now) noexcept {
  return is_same_place(before, now) && before.covariance == now.covariance;
}

MapChanges map_changes(const LandmarkMap& before, const LandmarkMap& now) noexcept {
  MapChanges changes;
  for (const MappedLandmark& old : before.landmarks()) {
    const MappedLandmark* landmark = now.find(old.id);
    if (landmark == nullptr)
      ++changes.removed;
    else if (!is_same_place(old, *landmark))
      ++changes.moved;
    else if (old.code != landmark->code || old.covariance != landmark->covariance)
      ++changes.described;
  }
  changes.added = now.landmarks().size() + changes.removed - before.landmarks().size();
  return changes;
}

}  // namespace ninedot
