#pragma once
/// What the page is told, as JSON: numbers in mm, degrees and ms; not a number is null.
#include <string>
#include <string_view>

#include "base/mono_time.h"
#include "config/config.h"
#include "proto/tap_layout.h"

namespace ninedot {

/// What is constant while the service runs: software, camera, landmark.
std::string camera_json(const TapHeader& header);
/// One frame. \param now  the pose's age counts up to it
std::string frame_json(const TapFrame& frame, MonoTime now);
std::string service_json(const TapService& service, MonoTime now);
/// Landmarks with a place. \param config  with its map read
std::string map_json(const Config& config);
/// All that the configuration has itself, with a place or without. \param config  likewise
std::string landmarks_json(const Config& config);

}  // namespace ninedot
