#pragma once
/// From recordings to what their pictures show of the landmarks.
#include <functional>
#include <string>
#include <vector>

#include "config/config.h"
#include "geometry/camera_model.h"
#include "mapping/recorded_sightings.h"

namespace ninedot {

/// Every picture once through the localiser; those that show a landmark or more. Landmarks whose fit the picture
/// contradicts, or that nothing identifies, are left out; mirror images and uncertain poses are not, since maps need no
/// pose but where the dots are. What the next pictures tell of how a landmark moved while its rows were exposed is in
/// them (mapping/row_interpolation.h); each says how uncertain its rows make it (LandmarkSighting::turn_sigma_rad).
/// \param index     goes into RecordedSightings::recording
/// \param progress  called for every picture; may be empty
/// Throws StartupError: kWorkFailed when a picture can't be read, kWrongUsage when the calibration is for other
/// pictures.
std::vector<RecordedSightings> collect_sightings(
    const std::string& recording, std::size_t index, const Config& config, const CameraModel& camera,
    const std::function<void(std::size_t frame, std::size_t frames)>& progress);

}  // namespace ninedot
