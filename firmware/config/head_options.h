#pragma once
/// From [pan_tilt] of the configuration to the aiming step and the calibration of its axes.
#include "aim/aimer.h"
#include "aim/servo_axis.h"
#include "config/config_checks.h"

namespace ninedot {

/// Axes that can't be: ends in the wrong order, a neutral position beyond them, a calibration that turns back.
void check_head_axes(const PanTiltConfig& config, ConfigProblems& problems);

/// The three below: for axes without a problem (contract).
AimOptions aim_options(const PanTiltConfig& config);
AimOrder first_order(const PanTiltConfig& config);
ServoAxes servo_axes(const PanTiltConfig& config);

}  // namespace ninedot
