#pragma once
/// From [pan_tilt] of the configuration to the aiming step and the calibration of its axes.
#include "aim/aimer.h"
#include "aim/servo_axis.h"
#include "config/config_checks.h"
#include "geometry/body.h"

namespace ninedot {

/// Axes that can't be: ends in the wrong order, a neutral position beyond them, a calibration that turns back.
void check_head_axes(const PanTiltConfig& config, ConfigProblems& problems);

/// The four below: for axes without a problem (contract).
/// \param body  the head's axes and the camera on them
AimOptions aim_options(const PanTiltConfig& config, const BodyGeometry& body = {});
/// Where a head is taken to be when it is switched on, unless it knows.
HeadAngles start_angles(const PanTiltConfig& config);
AimOrder first_order(const PanTiltConfig& config);
ServoAxes servo_axes(const PanTiltConfig& config);

}  // namespace ninedot
