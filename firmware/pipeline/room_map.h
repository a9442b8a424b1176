#pragma once
/// A map as a localiser works with it: prepared, with what the frames say of its landmarks. It is made at the start, or
/// on another thread while the localiser works with the one before.
#include <cstdint>
#include <vector>

#include "base/object_handoff.h"
#include "pipeline/code_identity.h"
#include "world/landmark_map.h"
#include "world/world_solver.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one at a time.
struct RoomMap {
  /// \param max_ambiguity  of a place of the camera, 0..1
  RoomMap(const LandmarkGeometry& landmark, LandmarkMap of, double max_ambiguity);

  /// Takes the place of `before`: what the frames said of sheets that both maps have in the same place stays known.
  /// Compares two landmarks for each of this map: 0.1 ms for 1000. \return  whether the track of the camera may go on:
  /// all that it stands on hangs where it hung. Memory: none.
  bool take_over(const RoomMap& before) noexcept;

  LandmarkMap map;
  CodeIdentity codes;
  WorldSolver world;
  // By landmark of the map.
  std::vector<std::uint8_t> missed;         ///< how often it was not where the map lets expect it
  std::vector<std::uint8_t> wait;           ///< frames until it is looked for there again
  std::vector<std::uint8_t> carries_track;  ///< 1: the track of the camera has used it since it began
};

/// Between the thread that reads maps and the localiser, which looks between two frames.
using RoomMapHandoff = ObjectHandoff<RoomMap>;

}  // namespace ninedot
