#pragma once
/// Which calibration a recording's pictures are read with.
#include <string>

#include "calibrate/camera_file.h"
#include "config/config.h"
#include "drivers/recording/recording_source.h"

namespace ninedot {

/// \param file  what the command line names; empty: the recording's own camera.yaml, else the configuration's
/// Throws StartupError(kWrongUsage): there is none, it is damaged, or `file` is of another camera than the recording's
/// own, where both name theirs.
CameraCalibration recording_calibration(const std::string& recording, const std::string& file, const Config& config);

/// The camera of it alone; of a zoom camera's the one at [pan_tilt] zoom. Throws likewise where that is not there.
CameraModel recording_camera(const std::string& recording, const std::string& file, const Config& config);

/// Throws StartupError(kWrongUsage): the calibration is for pictures of another size.
void check_picture_size(const RecordingSource& source, const CameraModel& camera, const std::string& recording);

}  // namespace ninedot
