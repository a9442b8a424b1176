#include "config/head_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "aim/evi_d31.h"
#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

std::vector<AxisPoint> axis_points(const HeadAxisConfig& axis, double centre, double per_deg) {
  if (!axis.calibration.empty()) return axis.calibration;
  std::vector<AxisPoint> points;
  const double slope = axis.direction == "reversed" ? -per_deg : per_deg;
  for (const double angle_deg : {-90.0, 90.0}) points.push_back({angle_deg * kRadPerDeg, centre + slope * angle_deg});
  return points;
}

/// One of the two, with what is not in its own table.
struct Axis {
  const PanTiltConfig& head;
  const HeadAxisConfig& own;
  const char* table;
  double visca_end_steps, visca_end_deg;  ///< the end of a VISCA camera's own range on the positive side
  bool is_visca() const { return head.driver == "visca"; }
};
// Such a camera counts pan to the right.
Axis pan_of(const PanTiltConfig& head) {
  return {head, head.pan, "pan_tilt.pan", -kEviD31MaxPanSteps, kEviD31MaxPan_deg};
}
Axis tilt_of(const PanTiltConfig& head) {
  return {head, head.tilt, "pan_tilt.tilt", kEviD31MaxTiltSteps, kEviD31MaxTilt_deg};
}

std::vector<AxisPoint> points_of(const Axis& axis) {
  return axis.is_visca() ? axis_points(axis.own, 0, axis.visca_end_steps / axis.visca_end_deg)
                         : axis_points(axis.own, axis.own.centre_us, axis.own.us_per_deg);
}

/// Outputs that no command goes beyond. A VISCA camera has no pulses: there they are the ends of the angles' range and
/// of its own.
ServoAxis servo_axis(const Axis& axis) {
  const std::vector<AxisPoint> points = points_of(axis);
  if (!axis.is_visca()) return {points, axis.own.min_us, axis.own.max_us};
  const ServoAxis endless(points, -1e6, 1e6);
  const double a = endless.output_at(axis.own.min_deg * kRadPerDeg).value;
  const double b = endless.output_at(axis.own.max_deg * kRadPerDeg).value;
  const double end = std::abs(axis.visca_end_steps);
  return {points, std::max(std::min(a, b), -end), std::min(std::max(a, b), end)};
}

void check_axis(const Axis& axis, ConfigProblems& problems) {
  const HeadAxisConfig& own = axis.own;
  const std::size_t count_before = problems.list.size();
  const auto refuse = [&](const char* key, const std::string& what) {
    problems.add(problems.line_of(fmt::format("{}.{}", axis.table, key)), fmt::format("'{}' {}", key, what));
  };
  if (!ServoAxis::accepts(points_of(axis)))
    refuse("calibration",
           fmt::format("is of no use; write 2 to {} pairs whose angles rise and whose outputs all rise or all fall",
                       ServoAxis::kMaxPoints));
  if (own.min_deg >= own.max_deg)
    refuse("max_deg", fmt::format("is {}; write more than min_deg = {}", own.max_deg, own.min_deg));
  else if (own.neutral_deg < own.min_deg || own.neutral_deg > own.max_deg)
    refuse("neutral_deg",
           fmt::format("is {}; write {} to {}, min_deg to max_deg", own.neutral_deg, own.min_deg, own.max_deg));
  if (!axis.is_visca() && own.min_us >= own.max_us)
    refuse("max_us", fmt::format("is {}; write more than min_us = {}", own.max_us, own.min_us));
  else if (!axis.is_visca() && own.max_us > axis.head.period_ms * 1000 / 2)
    refuse("max_us",
           fmt::format("is {}; a pulse must be shorter than half of period_ms = {}", own.max_us, axis.head.period_ms));
  if (problems.list.size() > count_before) return;  // without these there is no axis to ask

  const double neutral_rad = own.neutral_deg * kRadPerDeg;
  if (axis.is_visca()) {
    const double neutral_steps = ServoAxis(points_of(axis), -1e6, 1e6).output_at(neutral_rad).value;
    if (std::abs(neutral_steps) > std::abs(axis.visca_end_steps))
      refuse("neutral_deg", fmt::format("is {}, beyond the camera's own range", own.neutral_deg));
  } else if (servo_axis(axis).output_at(neutral_rad).limited) {
    refuse("neutral_deg", fmt::format("is {}, a pulse outside of min_us = {} to max_us = {}", own.neutral_deg,
                                      own.min_us, own.max_us));
  }
}

AimAxis aim_axis(const HeadAxisConfig& axis) {
  return {axis.min_deg * kRadPerDeg, axis.max_deg * kRadPerDeg, axis.slew_deg_per_s * kRadPerDeg};
}

HeadAngles neutral(const PanTiltConfig& config) {
  return {config.pan.neutral_deg * kRadPerDeg, config.tilt.neutral_deg * kRadPerDeg};
}

}  // namespace

void check_head_axes(const PanTiltConfig& config, ConfigProblems& problems) {
  check_axis(pan_of(config), problems);
  check_axis(tilt_of(config), problems);
}

AimOptions aim_options(const PanTiltConfig& config) {
  AimOptions options;
  options.pan = aim_axis(config.pan);
  options.tilt = aim_axis(config.tilt);
  options.neutral = neutral(config);
  options.dead_band_rad = config.dead_band_deg * kRadPerDeg;
  options.gain = config.gain;
  return options;
}

AimOrder first_order(const PanTiltConfig& config) { return {config.follow, neutral(config)}; }

ServoAxes servo_axes(const PanTiltConfig& config) {
  ConfigProblems problems;
  check_head_axes(config, problems);
  EXPECTS(problems.list.empty());
  return {servo_axis(pan_of(config)), servo_axis(tilt_of(config))};
}

}  // namespace ninedot
