#pragma once
/// Pictures to try the software on, with what is true of them.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/renderer.h"

namespace ninedot::bench {

struct Shot {
  test::Picture picture;
  std::optional<test::CameraPose> truth;  ///< none: no landmark is in the picture
  double bound_m = 0;                     ///< 1 sigma of the position that no estimator undercuts; 0: unknown
  std::chrono::milliseconds at{};         ///< after the strip's first
};

/// One picture, or the consecutive frames of a track. Starts with software that has seen nothing before.
struct Strip {
  std::string kind;  ///< row of the table
  std::string name;  ///< tells it from all others of its kind; goes into file names
  std::vector<Shot> shots;
  bool in_room = false;  ///< through the path of a room: see judge
};

/// The same picture as often as a room's path needs to follow what it saw in the first one, and to be sure of it.
inline std::vector<Shot> seen_three_times(const Shot& shot) {
  std::vector<Shot> shots(3, shot);
  for (std::size_t i = 0; i < shots.size(); ++i) shots[i].at = static_cast<int>(i) * std::chrono::milliseconds(28);
  return shots;
}

/// One row of the table.
struct Kind {
  std::string group;  ///< table
  std::string name;   ///< unique among all
};

/// Draws strips and hands them over, each as soon as it is there.
/// Threads: jobs run at the same time, each on one thread.
using Taker = std::function<void(Strip)>;
using Job = std::function<void(const Taker&)>;

/// The lens of all pictures, without distortion.
inline test::Lens trust_lens() { return {}; }

}  // namespace ninedot::bench
