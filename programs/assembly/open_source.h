#pragma once
/// From [camera] of the configuration to frames and their calibration.
#include <memory>
#include <string>

#include "calibrate/camera_file.h"
#include "config/config.h"
#include "drivers/simulation/simulated_head.h"
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
  std::shared_ptr<HeadLine> head_line;  ///< to the servos of a simulated camera; null: it is none
  bool tells_zoom = false;              ///< a recording whose frames say where the zoom stood
};

/// Throws StartupError(kWrongUsage) when `device` is missing. A simulated camera needs none.
void check_device_named(const CameraConfig& config);

/// Throws StartupError(kWrongUsage): `focus_position` is there although the focus is not fixed.
void check_focus(const CameraConfig& config);

/// The file of the calibration for [camera]: `calibration`, or the recording's own camera.yaml.
/// Throws StartupError(kWrongUsage): none is named.
std::string calibration_file(const CameraConfig& config);

/// The calibration in it. A simulated camera without one has default_simulated_camera's.
/// Throws StartupError(kWrongUsage): there is none, it is damaged, or it is for pictures of another size than width_px
/// x height_px.
CameraCalibration read_camera_calibration(const CameraConfig& config);

/// Of a simulated camera, whatever `source` says: `calibration`, or default_simulated_camera's. Throws likewise.
CameraModel simulated_camera_model(const CameraConfig& config);

/// A simulated camera goes on in real time, also with kEveryFrame; in which it ends after `duration_s`.
/// Throws StartupError: kWrongUsage when `device` is missing or a simulation cannot be, kWorkFailed when it can't be
/// opened. A camera that can't be opened is CameraRefused, unless `demand` is kNewest: then frames come once
/// it is there. Frames of another size than width_px x height_px fail with kFrameSize.
/// \param calibration  of the camera, or one that is to be made: another camera than the one that it names is refused,
/// and a lens that focuses by itself; null: there is none
OpenedSource open_source(const Config& config, FrameDemand demand, const CalibrationRecord* calibration);

/// The source with its calibration, which must be there. A recording that is missing is told of before its calibration
/// is. \param calibration  out. Throws StartupError as the two do.
OpenedSource open_calibrated_source(const Config& config, FrameDemand demand, CameraCalibration& calibration);

}  // namespace ninedot
