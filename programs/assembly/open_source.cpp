#include "programs/assembly/open_source.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <system_error>

#include "base/startup_error.h"
#include "drivers/camera/libcamera_device.h"
#include "drivers/camera/reopening_source.h"
#include "drivers/camera/v4l2_device.h"
#include "drivers/recording/recording_source.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/simulation_options.h"
#include "programs/assembly/zoom_choice.h"

namespace ninedot {
namespace {

std::string describe_recording_failure(const FrameSource& frames) {
  return static_cast<const RecordingSource&>(frames).last_failure();
}

OpenedSource open_recording(const CameraConfig& config, FrameDemand demand) {
  RecordingOptions options;
  options.size = {config.width_px, config.height_px};
  if (demand == FrameDemand::kNewest) {
    options.pace = config.every_frame ? RecordingPace::kAsTaken : RecordingPace::kRealTime;
    options.rate_hz = config.rate_hz;
    options.loop = config.loop;
  }
  auto source = std::make_unique<RecordingSource>(config.device, options);
  const std::size_t frame_count = options.loop ? 0 : source->frame_count();
  const bool tells_zoom = source->tells_zoom();
  return {std::move(source), describe_recording_failure, {}, {}, frame_count, nullptr, tells_zoom};
}

PowerLine power_line_of(const std::string& name) {
  if (name == "off") return PowerLine::kOff;
  if (name == "50Hz") return PowerLine::k50Hz;
  if (name == "60Hz") return PowerLine::k60Hz;
  return name == "automatic" ? PowerLine::kAutomatic : PowerLine::kUnchanged;
}

Focus focus_of(const std::string& name) {
  if (name == "fixed") return Focus::kFixed;
  return name == "automatic" ? Focus::kAutomatic : Focus::kUnchanged;
}

std::chrono::nanoseconds from_us(double us) { return std::chrono::nanoseconds(std::llround(us * 1000)); }

CameraRequest camera_request(const CameraConfig& config, const CalibrationRecord* calibration) {
  CameraRequest request;
  request.device = config.device;
  request.width_px = config.width_px;
  request.height_px = config.height_px;
  request.rate_hz = config.rate_hz;
  request.pixel_format = config.pixel_format;
  request.exposure = from_us(config.exposure_us);
  request.gain = config.gain;
  request.bayer = {config.black_level, config.red_gain, config.blue_gain};
  request.lower_rate_in_the_dark = config.lower_rate_in_the_dark;
  request.power_line = power_line_of(config.power_line);
  request.readout = from_us(config.readout_us);
  request.expected_row_time = from_us(config.row_time_us.value_or(0));
  request.focus = focus_of(config.focus);
  request.focus_position = config.focus_position;
  request.is_calibrated = calibration != nullptr;
  if (calibration != nullptr) request.calibrated_id = calibration->camera_id;
  return request;
}

OpenedSource open_camera(std::unique_ptr<CameraDevice> device, const CameraConfig& config, FrameDemand demand) {
  ReopenOptions options;
  options.stall_periods = config.stall_frames;
  options.wait_for_device = demand == FrameDemand::kNewest;
  auto source = std::make_unique<ReopeningSource>(std::move(device), options);
  std::string refusal = source->last_refusal();
  std::string description = refusal.empty() ? source->description() : std::string();
  return {std::move(source), nullptr, std::move(description), std::move(refusal), 0, nullptr, false};
}

OpenedSource open_simulation(const Config& config, FrameDemand demand) {
  constexpr std::uint64_t kSeed = 1;
  CameraCalibration calibration = read_camera_calibration(config.camera);
  choose_zoom(calibration, config.pan_tilt, false);
  SimulationOptions options = simulation_options(config, calibration.camera, kSeed);
  options.loop = demand == FrameDemand::kNewest && config.camera.loop;
  OpenedSource opened;
  opened.head_line = std::make_shared<HeadLine>();
  opened.frames = std::make_unique<SimulatedCamera>(options, opened.head_line, machine_clock());
  opened.description =
      fmt::format("simulated, {:.1f} s of a robot's way{}", options.duration_s, options.loop ? ", over and over" : "");
  return opened;
}

}  // namespace

std::string calibration_file(const CameraConfig& config) {
  if (!config.calibration.empty()) return config.calibration;
  if (config.source == "recording" && !config.device.empty()) return recording_camera_file(config.device);
  throw StartupError(ExitStatus::kWrongUsage,
                     "camera.calibration is missing: write the camera.yaml of this camera and lens");
}

CameraCalibration read_camera_calibration(const CameraConfig& config) {
  if (config.source == "simulated" && config.calibration.empty()) return {default_simulated_camera(config), {}, {}};
  const std::string path = calibration_file(config);
  // Whatever else is wrong with a path, too long for instance, reading it says.
  if (std::error_code error; !std::filesystem::exists(path, error) && !error)
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}: no such calibration; set camera.calibration", path));
  const CameraCalibration calibration = read_calibration_file(path);
  const CameraModel& camera = calibration.camera;
  if (camera.width_px != config.width_px || camera.height_px != config.height_px)
    throw StartupError(
        ExitStatus::kWrongUsage,
        fmt::format("{}: the calibration is for {} x {} px, but the camera gives {} x {}; calibrate this size, or set "
                    "camera.width_px and height_px",
                    path, camera.width_px, camera.height_px, config.width_px, config.height_px));
  return calibration;
}

CameraModel simulated_camera_model(const CameraConfig& config) {
  return config.calibration.empty() ? default_simulated_camera(config) : read_camera_calibration(config).camera;
}

void check_device_named(const CameraConfig& config) {
  if (!config.device.empty() || config.source == "simulated") return;
  throw StartupError(ExitStatus::kWrongUsage,
                     config.source == "recording"
                         ? "camera.device is missing: write the recording's folder or .y4m file into the configuration"
                         : "camera.device is missing: `ninedot cameras` lists what is there");
}

void check_focus(const CameraConfig& config) {
  if (config.focus_position < 0 || config.focus == "fixed") return;
  throw StartupError(ExitStatus::kWrongUsage,
                     fmt::format("camera.focus_position has no effect while camera.focus is \"{}\": write focus = "
                                 "\"fixed\", or remove it",
                                 config.focus));
}

OpenedSource open_source(const Config& configuration, FrameDemand demand, const CalibrationRecord* calibration) {
  const CameraConfig& config = configuration.camera;
  check_device_named(config);
  check_focus(config);
  if (config.source == "simulated") return open_simulation(configuration, demand);
  if (config.source == "recording") return open_recording(config, demand);
  if (config.source == "libcamera")
    return open_camera(std::make_unique<LibcameraDevice>(camera_request(config, calibration)), config, demand);
  return open_camera(std::make_unique<V4l2Device>(camera_request(config, calibration)), config, demand);
}

OpenedSource open_calibrated_source(const Config& config, FrameDemand demand, CameraCalibration& calibration) {
  if (config.camera.source == "recording") {
    OpenedSource source = open_source(config, demand, nullptr);
    calibration = read_camera_calibration(config.camera);
    return source;
  }
  check_device_named(config.camera);
  calibration = read_camera_calibration(config.camera);
  return open_source(config, demand, &calibration.record);
}

}  // namespace ninedot
