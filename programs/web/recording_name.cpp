#include "programs/web/recording_name.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>

namespace ninedot {
namespace {

constexpr std::string_view kAsked = "-asked", kLoss = "-loss";
constexpr std::string_view kTime = "dddddddd-dddddd";
// Six digits, and more only where a recording has a million pictures.
constexpr std::size_t kLeastDigits = 6, kMostDigits = 9;

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

bool is_numbered(std::string_view file, std::string_view folder, std::string_view ending) noexcept {
  if (!file.starts_with(folder) || !file.ends_with(ending) || file.size() < folder.size() + ending.size()) return false;
  const std::string_view digits = file.substr(folder.size(), file.size() - folder.size() - ending.size());
  return digits.size() >= kLeastDigits && digits.size() <= kMostDigits &&
         std::all_of(digits.begin(), digits.end(), is_digit);
}

}  // namespace

std::string time_name(std::chrono::system_clock::time_point begun) {
  return fmt::format("{:%Y%m%d-%H%M%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(begun)));
}

bool is_time_name(std::string_view name) noexcept {
  if (name.size() != kTime.size()) return false;
  for (std::size_t i = 0; i < kTime.size(); ++i)
    if (kTime[i] == 'd' ? !is_digit(name[i]) : name[i] != kTime[i]) return false;
  return true;
}

std::string recording_name(std::chrono::system_clock::time_point begun, RecordingCause cause) {
  return time_name(begun).append(cause == RecordingCause::kAsked ? kAsked : kLoss);
}

bool is_recording_name(std::string_view name) noexcept {
  if (!is_time_name(name.substr(0, kTime.size()))) return false;
  name.remove_prefix(kTime.size());
  return name == kAsked || name == kLoss;
}

RecordingCause cause_of(std::string_view name) noexcept {
  return name.ends_with(kLoss) ? RecordingCause::kLoss : RecordingCause::kAsked;
}

std::optional<RecordingPath> parse_recording_path(std::string_view path) noexcept {
  const std::size_t slash = path.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const RecordingPath found{path.substr(0, slash), path.substr(slash + 1)};
  if (!is_recording_name(found.name)) return std::nullopt;
  if (found.file == "download") return RecordingPath{found.name, {}};
  if (found.file == "frames.csv" || found.file == "camera.json" || is_numbered(found.file, "frames/", ".png") ||
      is_numbered(found.file, "reports/", ".json"))
    return found;
  return std::nullopt;
}

}  // namespace ninedot
