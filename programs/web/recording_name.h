#pragma once
/// What recordings are called: made by the server alone, so that whatever else comes as a name is refused.
///
///     20261123-121415-asked     begun at that time, UTC, because somebody pressed the button
///     20261123-121503-loss      because the landmark was lost
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ninedot {

/// "20261123-121415": of what somebody began, UTC. \param begun  as of recording_name
std::string time_name(std::chrono::system_clock::time_point begun);
/// To the last character.
bool is_time_name(std::string_view name) noexcept;

enum class RecordingCause : std::uint8_t { kAsked, kLoss };

/// \param begun  by the wall clock, for people: nothing is computed from it
std::string recording_name(std::chrono::system_clock::time_point begun, RecordingCause cause);
/// Digits, dashes and the cause, to the last character: no such name leads out of a folder.
bool is_recording_name(std::string_view name) noexcept;
/// \param name  is_recording_name (contract)
RecordingCause cause_of(std::string_view name) noexcept;

/// A file of a recording, as a request names it.
struct RecordingPath {
  std::string_view name;  ///< is_recording_name
  std::string_view file;  ///< below the recording's folder; empty: all of it, as an archive
};

/// \param path  what follows /api/recordings/ : NAME/download, NAME/frames.csv, NAME/camera.json,
/// NAME/frames/NNNNNN.png, NAME/reports/NNNNNN.json, to the last character.
/// Nothing where it is none of these. Lifetime: as the text's.
std::optional<RecordingPath> parse_recording_path(std::string_view path) noexcept;

}  // namespace ninedot
