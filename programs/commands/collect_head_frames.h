#pragma once
/// From recordings to what their pictures show of the landmarks, and where the head stood.
#include <string>
#include <vector>

#include "calibrate_head/head_stops.h"
#include "config/config.h"
#include "pipeline/frame_processor.h"

namespace ninedot {

/// A frame as the calibration of a head takes it: sightings that can be read in more than one way count, since where
/// the dots are is known all the same. \param told  at its exposure
HeadFrame head_frame_of(const Fix& fix, MonoTime exposed_at, const HeadAngles& told, std::size_t recording);

/// Every picture of the recordings, with the angles of frames.csv. SIGINT and SIGTERM end the looking.
/// \param landmark  out: its lengths
/// Throws StartupError: kWrongUsage where a recording, or its calibration, can't be; kWorkFailed where a picture can't
/// be read.
std::vector<HeadFrame> collect_head_frames(const std::vector<std::string>& recordings, const std::string& camera_file,
                                           const Config& config, LandmarkGeometry& landmark);

}  // namespace ninedot
