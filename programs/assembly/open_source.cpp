#include "programs/assembly/open_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "base/startup_error.h"
#include "calibrate/camera_file.h"
#include "drivers/camera/libcamera_device.h"
#include "drivers/camera/reopening_source.h"
#include "drivers/camera/v4l2_device.h"
#include "drivers/recording/recording_source.h"
#include "programs/assembly/input_files.h"

namespace ninedot {
namespace {

constexpr std::array<std::string_view, 3> kSourcesOfThisBuild{"recording", "v4l2", "libcamera"};

std::string describe_recording_failure(const FrameSource& frames) {
  return static_cast<const RecordingSource&>(frames).last_failure();
}

OpenedSource open_recording(const CameraConfig& config, FrameDemand demand) {
  RecordingOptions options;
  options.size = {config.width_px, config.height_px};
  if (demand == FrameDemand::kNewest) {
    options.pace = RecordingPace::kRealTime;
    options.rate_hz = config.rate_hz;
    options.loop = config.loop;
  }
  auto source = std::make_unique<RecordingSource>(config.device, options);
  const std::size_t frame_count = options.loop ? 0 : source->frame_count();
  return {std::move(source), describe_recording_failure, {}, {}, frame_count};
}

PowerLine power_line_of(const std::string& name) {
  if (name == "off") return PowerLine::kOff;
  if (name == "50Hz") return PowerLine::k50Hz;
  if (name == "60Hz") return PowerLine::k60Hz;
  return name == "automatic" ? PowerLine::kAutomatic : PowerLine::kUnchanged;
}

std::chrono::nanoseconds from_us(double us) { return std::chrono::nanoseconds(std::llround(us * 1000)); }

CameraRequest camera_request(const CameraConfig& config) {
  CameraRequest request;
  request.device = config.device;
  request.width_px = config.width_px;
  request.height_px = config.height_px;
  request.rate_hz = config.rate_hz;
  request.pixel_format = config.pixel_format;
  request.exposure = from_us(config.exposure_us);
  request.gain = config.gain;
  request.lower_rate_in_the_dark = config.lower_rate_in_the_dark;
  request.power_line = power_line_of(config.power_line);
  request.readout = from_us(config.readout_us);
  return request;
}

OpenedSource open_camera(std::unique_ptr<CameraDevice> device, const CameraConfig& config, FrameDemand demand) {
  ReopenOptions options;
  options.stall_periods = config.stall_frames;
  options.wait_for_device = demand == FrameDemand::kNewest;
  auto source = std::make_unique<ReopeningSource>(std::move(device), options);
  std::string refusal = source->last_refusal();
  std::string description = refusal.empty() ? source->description() : std::string();
  return {std::move(source), nullptr, std::move(description), std::move(refusal), 0};
}

}  // namespace

std::string calibration_file(const CameraConfig& config) {
  if (!config.calibration.empty()) return config.calibration;
  if (config.source == "recording" && !config.device.empty()) return recording_camera_file(config.device);
  throw StartupError(ExitStatus::kWrongUsage,
                     "camera.calibration is missing: write the camera.yaml of this camera and lens");
}

CameraModel read_camera_calibration(const CameraConfig& config) {
  const std::string path = calibration_file(config);
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
  if (std::ranges::find(kSourcesOfThisBuild, config.source) == kSourcesOfThisBuild.end())
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("camera.source is '{}', but this build has only {}",
                                                            config.source, fmt::join(kSourcesOfThisBuild, ", ")));
}

void check_device_named(const CameraConfig& config) {
  if (!config.device.empty()) return;
  throw StartupError(ExitStatus::kWrongUsage,
                     config.source == "recording"
                         ? "camera.device is missing: write the recording's folder or .y4m file into the configuration"
                         : "camera.device is missing: `ninedot cameras` lists what is there");
}

OpenedSource open_source(const CameraConfig& config, FrameDemand demand) {
  check_source(config);
  check_device_named(config);
  if (config.source == "recording") return open_recording(config, demand);
  if (config.source == "libcamera")
    return open_camera(std::make_unique<LibcameraDevice>(camera_request(config)), config, demand);
  return open_camera(std::make_unique<V4l2Device>(camera_request(config)), config, demand);
}

}  // namespace ninedot
