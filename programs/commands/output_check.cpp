#include "programs/commands/output_check.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "base/startup_error.h"
#include "drivers/recording/recording_index.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// A device loses nothing by what is written to it: /dev/null may stand for several.
bool is_file_name(const std::string& path) {
  std::error_code none;
  return !path.empty() && path != "-" && !fs::is_character_file(path, none);
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  return fs::weakly_canonical(fs::absolute(a, error), error) == fs::weakly_canonical(fs::absolute(b, error), error);
}

/// A recording's pictures and their times; its camera.yaml is there to be replaced.
bool is_of_recording(const fs::path& file, const fs::path& recording) {
  std::error_code error;
  if (!fs::is_directory(recording, error)) return false;
  return is_same_file(file, recording / "frames.csv") || is_same_file(file, recording / "frames") ||
         is_same_file(file.parent_path(), recording / "frames");
}

bool is_same_place(const std::string& a, const std::string& b) {
  return is_file_name(a) && is_file_name(b) ? is_same_file(a, b) : a == "-" && b == "-";
}

}  // namespace

void check_outputs(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedOutput& output = outputs[i];
    for (std::size_t other = 0; other < i; ++other)
      if (is_same_place(outputs[other].path, output.path))
        throw StartupError(
            ExitStatus::kWrongUsage,
            fmt::format("{} would be written twice, by {} and by {}: name two files",
                        output.path == "-" ? "standard output" : output.path, outputs[other].option, output.option));
    if (!is_file_name(output.path)) continue;
    for (const std::string& input : inputs)
      if (!input.empty() && (is_same_file(output.path, input) || is_of_recording(output.path, input)))
        throw StartupError(ExitStatus::kWrongUsage,
                           fmt::format("{} is read by this command: give {} another name", output.path, output.option));
  }
}

std::vector<std::string> files_of(const Config& config) { return {config.map, config.camera.calibration}; }

std::vector<std::string> files_of(const Config& config, const std::vector<std::string>& recordings,
                                  const std::string& camera) {
  std::vector<std::string> files = files_of(config);
  if (!camera.empty())
    files.push_back(camera);
  else
    for (const std::string& recording : recordings) files.push_back(recording_camera_file(recording));
  return files;
}

void check_named(const NamedOutput& output) {
  if (output.path.empty()) throw StartupError(ExitStatus::kWrongUsage, fmt::format("{} names no file", output.option));
}

}  // namespace ninedot
