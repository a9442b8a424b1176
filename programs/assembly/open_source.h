#pragma once
/// From [camera] of the configuration to frames and their calibration.
#include <memory>
#include <string>

#include "config/config.h"
#include "geometry/camera_model.h"
#include "ports/frame_source.h"

namespace ninedot {

enum class FrameDemand {
  kNewest,      ///< in real time, the newest frame wins, and a camera that is not there is waited for: for the service
  kEveryFrame,  ///< nothing may be lost where the source permits it: a recording plays as fast as it is read, once
};

struct OpenedSource {
  std::unique_ptr<FrameSource> frames;
  /// "FILE: what" about the last frame that failed, of the recording; empty where the source has no more to say than
  /// Error::text.
  std::string (*describe_failure)(const FrameSource& frames) = nullptr;
  /// What the camera agreed to, for the log: "GREY 640x480, 30 Hz, exposure 5000 us"; empty for a recording, and for a
  /// camera that is waited for.
  std::string description;
  std::string refusal;          ///< why the camera could not be opened and is waited for, one line; empty: it was
  std::size_t frame_count = 0;  ///< of a recording that does not loop; 0 = endless
};

/// Throws StartupError(kWrongUsage) when this build has no such source, naming those that it has.
void check_source(const CameraConfig& config);

/// Throws StartupError(kWrongUsage) when `device` is missing.
void check_device_named(const CameraConfig& config);

/// The file of the calibration for [camera]: `calibration`, or the recording's own camera.yaml.
/// Throws StartupError(kWrongUsage): none is named.
std::string calibration_file(const CameraConfig& config);

/// The calibration in it.
/// Throws StartupError(kWrongUsage): there is none, it is damaged, or it is for pictures of another size than width_px
/// x height_px.
CameraModel read_camera_calibration(const CameraConfig& config);

/// Throws StartupError: kWrongUsage when this build has no such source or `device` is missing, kWorkFailed when it
/// can't be opened. A camera that can't be opened is CameraRefused, unless `demand` is kNewest: then frames come once
/// it is there. Frames of another size than width_px x height_px fail with kFrameSize.
OpenedSource open_source(const CameraConfig& config, FrameDemand demand);

}  // namespace ninedot
