#pragma once
/// The tap that [tap] asks for.
#include <memory>
#include <string>

#include "config/config.h"
#include "drivers/tap/tap_writer.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "programs/service/tap_output.h"

namespace ninedot {

/// Must outlive the frame loop.
struct OpenedTap {
  std::unique_ptr<TapWriter> writer;  ///< null: not asked for, or refused
  std::unique_ptr<TapObserver> observer;
  std::string refusal;  ///< why it could not be had, one line: no reason to leave a robot without its position
};

OpenedTap open_tap(const Config& config, const CameraModel& camera, const LandmarkGeometry& landmark);

}  // namespace ninedot
