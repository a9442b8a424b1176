#include "app/open_source.h"

#include <fmt/format.h>

#include <filesystem>

#include "app/camera_file.h"
#include "base/startup_error.h"
#include "drivers/capture/recording_source.h"

namespace ninedot {
namespace {

constexpr const char* kSourceOfThisBuild = "recording";

std::string describe_recording_failure(const FrameSource& frames) {
  return static_cast<const RecordingSource&>(frames).last_failure();
}

OpenedSource open_recording(const CameraConfig& config, FrameDemand demand) {
  if (config.device.empty())
    throw StartupError(ExitStatus::kWrongUsage,
                       "camera.device is missing: write the recording's folder or .y4m file into the configuration");
  RecordingOptions options;
  options.size = {config.width_px, config.height_px};
  if (demand == FrameDemand::kNewest) {
    options.pace = RecordingPace::kRealTime;
    options.rate_hz = config.rate_hz;
    options.loop = config.loop;
  }
  auto source = std::make_unique<RecordingSource>(config.device, options);
  const std::size_t frame_count = options.loop ? 0 : source->frame_count();
  return {std::move(source), describe_recording_failure, frame_count};
}

}  // namespace

CameraModel read_camera_calibration(const CameraConfig& config) {
  std::string path = config.calibration;
  if (path.empty() && config.source == "recording" && !config.device.empty())
    path = recording_camera_file(config.device);
  if (path.empty())
    throw StartupError(ExitStatus::kWrongUsage,
                       "camera.calibration is missing: write the camera.yaml of this camera and lens");
  if (!std::filesystem::exists(path))
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}: no such calibration; set camera.calibration", path));
  const CameraModel camera = read_camera_file(path);
  if (camera.width_px != config.width_px || camera.height_px != config.height_px)
    throw StartupError(
        ExitStatus::kWrongUsage,
        fmt::format("{}: the calibration is for {} x {} px, but the camera gives {} x {}; calibrate this size, or set "
                    "camera.width_px and height_px",
                    path, camera.width_px, camera.height_px, config.width_px, config.height_px));
  return camera;
}

void check_source(const CameraConfig& config) {
  if (config.source != kSourceOfThisBuild)
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("camera.source is '{}', but this build has only '{}'",
                                                            config.source, kSourceOfThisBuild));
}

OpenedSource open_source(const CameraConfig& config, FrameDemand demand) {
  check_source(config);
  return open_recording(config, demand);
}

}  // namespace ninedot
