#pragma once
/// From [pan_tilt] of the configuration to the aiming step and the calibration of its axes.
#include <string>

#include "aim/aimer.h"
#include "aim/servo_axis.h"
#include "config/config.h"

namespace ninedot {

/// What is wrong with an axis of the head, and the key that it is about: {"", ""} = nothing.
struct HeadProblem {
  std::string key;  ///< "pan_tilt.pan.max_deg"
  std::string what;
};
HeadProblem find_head_problem(const PanTiltConfig& config);

/// The three below: for a configuration without a problem (contract).
AimOptions aim_options(const PanTiltConfig& config);
AimOrder first_order(const PanTiltConfig& config);
ServoAxes servo_axes(const PanTiltConfig& config);

}  // namespace ninedot
