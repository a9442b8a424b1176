#pragma once
/// What `ninedot calibrate pan-tilt` writes: sections of a configuration, with what is known of each number.
#include <string>
#include <vector>

#include "aim/servo_axis.h"
#include "calibrate_head/head_calibration.h"
#include "config/config.h"

namespace ninedot {

/// The table of pulses, or of steps, by true angle, in the place of what the axis has now.
/// \param said     the axis as it is configured, by told angle
/// \param corners  told angles [rad] at which `said` bends
/// \return  rising by angle; none: the corrected angles make no table
std::vector<AxisPoint> corrected_table(const AxisCalibration& axis, const ServoAxis& said,
                                       const std::vector<double>& corners);

/// [body], and where there is a driver [pan_tilt.pan] and [pan_tilt.tilt].
/// \param before  axes without a problem (contract) \param source  what it was made from
/// Throws StartupError(kWorkFailed): an axis makes no table.
std::string head_file_text(const HeadCalibration& head, const Config& before, const std::string& source);

/// "pan: 3 points, play 0.80 +- 0.02 deg, ..." : what a person is told, a line each.
std::vector<std::string> head_summary(const HeadCalibration& head);

}  // namespace ninedot
