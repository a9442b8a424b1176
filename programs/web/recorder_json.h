#pragma once
/// What a page is told of the recordings, as JSON: the newest first, times in ms.
#include <string>
#include <string_view>

#include "programs/web/recording_desk.h"

namespace ninedot {

/// What the state of the desk does not tell.
struct RecordingsContext {
  std::string_view why_not;  ///< why nothing is recorded
  bool may_ask = false;
  bool is_stopping = false;
  std::string_view problem;  ///< why this very request was refused
};

std::string recordings_json(const RecordingState& state, const RecordingsContext& context);

}  // namespace ninedot
