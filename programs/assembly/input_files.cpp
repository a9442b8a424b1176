#include "programs/assembly/input_files.h"

#include <filesystem>
#include <system_error>

#include "base/startup_error.h"
#include "drivers/posix/text_file.h"

namespace ninedot {
namespace {

/// Paths in a configuration are relative to the file that they stand in, wherever the program was started.
void make_absolute(std::string& path, const std::string& config_path) {
  if (!path.empty() && !std::filesystem::path(path).is_absolute())
    path = (std::filesystem::path(config_path).parent_path() / path).lexically_normal().string();
}

}  // namespace

Config read_config(const std::string& path) {
  ConfigProblems problems;
  Config config = read_config(path, problems);
  refuse_first(problems, path);
  return config;
}

void refuse_first(const ConfigProblems& problems, const std::string& path) {
  if (!problems.list.empty()) throw StartupError(ExitStatus::kWrongUsage, problem_text(path, problems.list.front()));
}

void read_map(Config& config, ConfigProblems& problems) {
  std::error_code unknown;
  // A fifo would be waited for without end, a device read without one.
  if (std::filesystem::exists(config.map, unknown) && !std::filesystem::is_regular_file(config.map, unknown))
    return problems.add(problems.line_of("map"), config.map + ": is no file: name the file that holds the map");
  std::string text;
  try {
    text = read_text_file(config.map, kMaxFile_bytes);
  } catch (const StartupError& error) {
    return problems.add(problems.line_of("map"), error.what());
  }
  read_map_text(text, config.map, config, problems);
}

Config read_config(const std::string& path, ConfigProblems& problems) {
  return read_config(read_text_file(path, kMaxFile_bytes), path, path, problems);
}

Config read_config(std::string_view text, const std::string& name, const std::string& path, ConfigProblems& problems,
                   const std::string& map) {
  Config config = read_config_text(text, name, problems);
  if (config.camera.source == "recording") make_absolute(config.camera.device, path);
  make_absolute(config.camera.calibration, path);
  make_absolute(config.map, path);
  if (!map.empty()) config.map = map;
  for (std::string* named : {&config.tap.path, &config.web.token_file, &config.web.certificate, &config.web.key})
    make_absolute(*named, path);
  if (!config.map.empty() && config.landmarks.empty()) read_map(config, problems);
  return config;
}

CameraCalibration read_calibration_file(const std::string& path) {
  return parse_calibration(read_text_file(path, kMaxFile_bytes), path);
}

CameraModel read_camera_file(const std::string& path) { return read_calibration_file(path).camera; }

}  // namespace ninedot
