#include "programs/assembly/recording_camera.h"

#include <fmt/format.h>
#include <unistd.h>

#include "base/startup_error.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/zoom_choice.h"

namespace ninedot {

CameraCalibration recording_calibration(const std::string& recording, const std::string& file, const Config& config) {
  if (!file.empty()) return read_calibration_file(file);
  const std::string own = recording_camera_file(recording);
  if (access(own.c_str(), F_OK) == 0) return read_calibration_file(own);
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
