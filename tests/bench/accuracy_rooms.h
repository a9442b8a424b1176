#pragma once
/// Walks through rendered rooms of coded landmarks, as `ninedot replay` would see them, beside the bound of all
/// landmarks together.
#include <cstdint>

#include "tests/bench/room_walk.h"

namespace ninedot::bench {

constexpr int kRoomWalks = 4;        ///< of a row, each through another room
constexpr int kRoomFrames = 15;      ///< of a walk
constexpr double kRoomRate_hz = 35;  ///< of its frames

/// How the camera was placed. Root mean squares are over the frames whose place is not `wrong`.
struct PlaceOutcome {
  int frames = 0;        ///< that have one
  int wrong = 0;         ///< of these: farther off than a tenth of the distance to the nearest landmark
  double rms_m = 0;      ///< error of the position, the three axes together
  double ratio = 0;      ///< median of the errors, each over its own frame's bound
  double per_sigma = 0;  ///< error over its stated 1-sigma, each axis by itself, root mean square: 1 is honest
};

struct RoomOutcome {
  int frames = 0;      ///< that show a landmark
  int shown = 0;       ///< landmarks, all frames together
  int found = 0;       ///< of these, by a search of the whole picture that knows of no other frame
  int identified = 0;  ///< of these, reported under their own number within a fifth of the distance of their true pose
  int wrong = 0;       ///< landmarks reported as valid that are not so
  double bound_m = 0;  ///< root mean square of the frames' joint bounds
  PlaceOutcome world;  ///< of single frames: rows of `--out-world`
  PlaceOutcome track;  ///< of all frames up to each one: rows of `--out-track`
};

/// Threads: independent of each other.
RoomOutcome run_walks(const RoomCondition& condition, std::uint64_t seed);

}  // namespace ninedot::bench
