#pragma once
/// Every picture of a recording once through the localiser, for calibrations.
#include <functional>
#include <string>
#include <vector>

#include "calibrate/camera_file.h"
#include "config/config.h"
#include "pipeline/frame_processor.h"

namespace ninedot {

struct SeenFrames {
  std::size_t frames = 0;       ///< that were looked at
  bool is_interrupted = false;  ///< by SIGINT or SIGTERM: the rest was not looked at
};

/// What is no recording, or has no picture, was named by mistake. Throws StartupError(kWrongUsage) in one line.
void check_recording(const std::string& recording);

/// A recording that is given twice, under one name or two, would count twice. Throws StartupError(kWrongUsage).
void refuse_repeated(const std::vector<std::string>& recordings);

/// What a recording was looked at with.
struct RecordingView {
  CameraModel camera;
  LandmarkGeometry landmark;
};

/// \param camera_file  of the command line; empty: the recording's own, then the configuration's
/// Throws StartupError(kWrongUsage): there is no such recording, no calibration, or one for pictures of another size.
RecordingView view_of_recording(const std::string& recording, const std::string& camera_file, const Config& config);

/// \param tracking  false: each picture is searched for itself
/// \param use  called for each picture; the fix and the observation (null: no landmark) are valid for the call
/// Shows progress on a terminal; ends at SIGINT and SIGTERM. Throws StartupError(kWorkFailed): a picture can't be read.
SeenFrames look_at_frames(
    const std::string& recording, const Config& config, const RecordingView& view, bool tracking,
    const std::function<void(const Frame& frame, const Fix& fix, const LandmarkObservation* seen)>& use);

/// "3 of 40 pictures were looked at" on standard error, where it was interrupted.
void tell_interruption(const SeenFrames& seen);

}  // namespace ninedot
