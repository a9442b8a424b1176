#pragma once
/// What somebody who moves a sheet before a camera is told while views are gathered.
#include <optional>
#include <string>
#include <vector>

#include "calibrate_camera/sufficiency.h"
#include "calibrate_camera/view_gatherer.h"

namespace ninedot {

struct GatheringState {
  ViewTally tally;
  std::vector<std::string> wanted;      ///< as wanted_views has it
  std::vector<std::string> lens_lacks;  ///< as what_lens_lacks has it; empty: not asked yet, or nothing
  std::optional<std::size_t> part;      ///< of kPartNames: where the sheet is now; nothing: not in the picture
  Looked looked = Looked::kNoSheet;     ///< what became of the newest picture
};

/// For a terminal: what is wanted, a map of the picture with how many views show the sheet where, and what to do now.
/// \param columns  of the window: sentences are broken there, the map is left as it is \return  each line with its end
std::string gathering_table(const GatheringState& state, std::size_t columns);

/// For a pipe: "12 views; wanted: lower left, nearer".
std::string gathering_line(const GatheringState& state);

}  // namespace ninedot
