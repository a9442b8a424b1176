#include "programs/assembly/recording_camera.h"

#include <fmt/format.h>
#include <unistd.h>

#include "base/startup_error.h"
#include "drivers/camera/camera_identity.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/zoom_choice.h"

namespace ninedot {
namespace {

/// A recording knows its camera by its own calibration alone. One that is damaged tells nothing: that may be why
/// another is given.
void check_same_camera(const CameraCalibration& calibration, const std::string& file, const std::string& own) {
  std::string recorded;
  try {
    recorded = read_calibration_file(own).record.camera_id;
  } catch (const StartupError&) {
    return;
  }
  if (is_same_camera(calibration.record.camera_id, recorded)) return;
  throw StartupError(
      ExitStatus::kWrongUsage,
      fmt::format("--camera {}: is of the camera {}, but {} says that the recording is of {}: give that camera's "
                  "calibration, or move {} away if it is the wrong one",
                  file, calibration.record.camera_id, own, recorded, own));
}

}  // namespace

CameraCalibration recording_calibration(const std::string& recording, const std::string& file, const Config& config) {
  const std::string own = recording_camera_file(recording);
  const bool has_own = access(own.c_str(), F_OK) == 0;
  if (!file.empty()) {
    CameraCalibration calibration = read_calibration_file(file);
    if (has_own) check_same_camera(calibration, file, own);
    return calibration;
  }
  if (has_own) return read_calibration_file(own);
  if (!config.camera.calibration.empty()) return read_calibration_file(config.camera.calibration);
  throw StartupError(ExitStatus::kWrongUsage,
                     fmt::format("{}: no calibration there: give one with --camera FILE", own));
}

CameraModel recording_camera(const std::string& recording, const std::string& file, const Config& config) {
  CameraCalibration calibration = recording_calibration(recording, file, config);
  choose_zoom(calibration, config.pan_tilt, false);
  return calibration.camera;
}

void check_picture_size(const RecordingSource& source, const CameraModel& camera, const std::string& recording) {
  if (source.size() == PictureSize{camera.width_px, camera.height_px}) return;
  throw StartupError(
      ExitStatus::kWrongUsage,
      fmt::format("{}: its pictures are {}x{}, but the calibration is for {}x{}: give the right one with "
                  "--camera FILE",
                  recording, source.size().width_px, source.size().height_px, camera.width_px, camera.height_px));
}

}  // namespace ninedot
