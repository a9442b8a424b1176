#include "programs/web/recorder_json.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json_text.h"

namespace ninedot {
namespace {

std::int64_t ms(std::chrono::nanoseconds time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

std::string entry_json(const ShelfEntry& entry) {
  return fmt::format(R"({{"name":"{}","why":"{}","frames":{},"missed":{},"bytes":{},"ms":{},"ended":{}}})", entry.name,
                     cause_of(entry.name) == RecordingCause::kLoss ? "loss" : "asked", entry.frames, entry.missed,
                     entry.bytes, ms(entry.duration), json_text(entry.ended));
}

const char* phase_name(const RecordingState& state) {
  if (!state.keeps_losses) return "off";
  if (state.is_saving) return "saving";
  switch (state.phase) {
    case LossRing::Phase::kBlind:
      return "blind";
    case LossRing::Phase::kWatching:
      return "watching";
    case LossRing::Phase::kLost:
    case LossRing::Phase::kReady:
      break;
  }
  return "lost";
}

}  // namespace

std::string recordings_json(const RecordingState& state, const RecordingsContext& context) {
  const char* const phase = context.is_stopping ? "stopping"
                            : state.running     ? "recording"
                            : state.is_awaited  ? "starting"
                                                : "idle";
  std::string list;
  std::for_each(state.entries.rbegin(), state.entries.rend(),
                [&list](const ShelfEntry& entry) { list.append(list.empty() ? "" : ",").append(entry_json(entry)); });
  const std::string loss =
      fmt::format(R"({{"phase":"{}","before_ms":{},"spacing_ms":{},"skipped":{},"memory":{}}})", phase_name(state),
                  ms(state.before), ms(state.spacing), state.skipped, state.ring_bytes);
  return fmt::format(
      R"({{"why_not":{},"may":{},"phase":"{}","running":{},"note":{},"problem":{},"bytes":{},"most_bytes":{},"longest_ms":{},"loss":{},"recordings":[{}]}})",
      json_text(context.why_not), context.may_ask, phase, state.running ? entry_json(*state.running) : "null",
      json_text(state.note), json_text(context.problem), state.bytes, state.most_bytes, ms(state.longest), loss, list);
}

}  // namespace ninedot
