#include "config/head_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
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

/// Positions of servos and cameras that count steps themselves.
struct StepScale {
  double centre;          ///< where 0 deg is
  double per_deg;         ///< positive: they count to the left and upwards
  double first, last;     ///< their whole range
  const char* whose_own;  ///< range it is
};

/// One of the two, with what is not in its own table.
struct Axis {
  const PanTiltConfig& head;
  const HeadAxisConfig& own;
  const char* table;
  std::optional<StepScale> steps;  ///< none: pulses
};

/// The middle of the range is straight ahead. Robotis e-Manual, XL430-W250, Goal Position, and Feetech, STS3215 memory
/// table: 4096 positions in a turn. Feetech's SCS0009: 1024 over 300 deg; others of that series turn less.
constexpr StepScale kEncoderSteps{2048, 4096 / 360.0, 0, 4095, "the servo's own"};
constexpr StepScale kPotentiometerSteps{512, 1024 / 300.0, 0, 1023, "the servo's own"};

std::optional<StepScale> scale_of(const std::string& driver, double visca_end_steps, double visca_end_deg) {
  if (driver == "visca") {
    const double end = std::abs(visca_end_steps);
    return StepScale{0, visca_end_steps / visca_end_deg, -end, end, "the camera's own"};
  }
  if (driver == "dynamixel" || driver == "feetech-sts") return kEncoderSteps;
  if (driver == "feetech-scs") return kPotentiometerSteps;
  return std::nullopt;
}

// A VISCA camera counts pan to the right.
Axis pan_of(const PanTiltConfig& head) {
  return {head, head.pan, "pan_tilt.pan", scale_of(head.driver, -kEviD31MaxPanSteps, kEviD31MaxPan_deg)};
}
Axis tilt_of(const PanTiltConfig& head) {
  return {head, head.tilt, "pan_tilt.tilt", scale_of(head.driver, kEviD31MaxTiltSteps, kEviD31MaxTilt_deg)};
}

std::vector<AxisPoint> points_of(const Axis& axis) {
  return axis.steps ? axis_points(axis.own, axis.steps->centre, axis.steps->per_deg)
                    : axis_points(axis.own, axis.own.centre_us, axis.own.us_per_deg);
}

/// Outputs that no command goes beyond. Where there are no pulses they are the ends of the angles' range and of the
/// hardware's own.
ServoAxis servo_axis(const Axis& axis) {
  const std::vector<AxisPoint> points = points_of(axis);
  if (!axis.steps) return {points, axis.own.min_us, axis.own.max_us};
  const ServoAxis endless(points, -1e6, 1e6);
  const double a = endless.output_at(axis.own.min_deg * kRadPerDeg).value;
  const double b = endless.output_at(axis.own.max_deg * kRadPerDeg).value;
  return {points, std::max(std::min(a, b), axis.steps->first), std::min(std::max(a, b), axis.steps->last)};
}

/// Places that the head is sent to without anybody's order.
struct OwnPlace {
  const char* key;
  std::optional<double> deg;
};
std::array<OwnPlace, 3> own_places(const HeadAxisConfig& axis) {
  return {{{"neutral_deg", axis.neutral_deg}, {"start_deg", axis.start_deg}, {"park_deg", axis.park_deg}}};
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
  else
    for (const auto& [key, deg] : own_places(own))
      if (deg && (*deg < own.min_deg || *deg > own.max_deg))
        refuse(key, fmt::format("is {}; write {} to {}, min_deg to max_deg", *deg, own.min_deg, own.max_deg));
  if (!axis.steps && own.min_us >= own.max_us)
    refuse("max_us", fmt::format("is {}; write more than min_us = {}", own.max_us, own.min_us));
  else if (!axis.steps && own.max_us > axis.head.period_ms * 1000 / 2)
    refuse("max_us",
           fmt::format("is {}; a pulse must be shorter than half of period_ms = {}", own.max_us, axis.head.period_ms));
  if (problems.list.size() > count_before) return;  // without these there is no axis to ask

  for (const auto& [key, deg] : own_places(own)) {
    if (!deg) continue;
    if (axis.steps) {
      const double steps = ServoAxis(points_of(axis), -1e6, 1e6).output_at(*deg * kRadPerDeg).value;
      if (steps < axis.steps->first || steps > axis.steps->last)
        refuse(key, fmt::format("is {}, beyond {} range", *deg, axis.steps->whose_own));
    } else if (servo_axis(axis).output_at(*deg * kRadPerDeg).limited) {
      refuse(key, fmt::format("is {}, a pulse outside of min_us = {} to max_us = {}", *deg, own.min_us, own.max_us));
    }
  }
}

AimAxis aim_axis(const HeadAxisConfig& axis) {
  return {axis.min_deg * kRadPerDeg, axis.max_deg * kRadPerDeg, axis.slew_deg_per_s * kRadPerDeg,
          axis.acceleration_deg_per_s2 * kRadPerDeg};
}

std::chrono::nanoseconds nanoseconds(double ms) { return std::chrono::nanoseconds(std::llround(ms * 1e6)); }

LandmarkChoice landmark_choice(const std::string& word) {
  if (word == "nearest") return LandmarkChoice::kNearest;
  if (word == "reported") return LandmarkChoice::kReported;
  return word == "id" ? LandmarkChoice::kById : LandmarkChoice::kHandOver;
}

HeadAngles neutral(const PanTiltConfig& config) {
  return {config.pan.neutral_deg * kRadPerDeg, config.tilt.neutral_deg * kRadPerDeg};
}

}  // namespace

void check_head_axes(const PanTiltConfig& config, ConfigProblems& problems) {
  check_axis(pan_of(config), problems);
  check_axis(tilt_of(config), problems);
}

AimOptions aim_options(const PanTiltConfig& config, const BodyGeometry& body) {
  AimOptions options;
  options.pan = aim_axis(config.pan);
  options.tilt = aim_axis(config.tilt);
  options.neutral = neutral(config);
  options.dead_band_rad = config.dead_band_deg * kRadPerDeg;
  options.gain = config.gain;
  options.park = {config.pan.park_deg.value_or(config.pan.neutral_deg) * kRadPerDeg,
                  config.tilt.park_deg.value_or(config.tilt.neutral_deg) * kRadPerDeg};
  options.head_delay = nanoseconds(config.head_delay_ms);
  options.coast = nanoseconds(config.coast_ms);
  options.park_after = nanoseconds(1000 * config.park_after_s);
  options.search = config.search;
  options.search_at_start = config.search_at_start;
  options.search_rad_per_s = config.search_deg_per_s * kRadPerDeg;
  options.landmark = landmark_choice(config.landmark);
  options.landmark_id = static_cast<std::uint16_t>(config.landmark_id);
  options.hand_over_margin = config.hand_over_margin_percent / 100;
  options.body = body;
  return options;
}

HeadAngles start_angles(const PanTiltConfig& config) {
  return {config.pan.start_deg.value_or(config.pan.neutral_deg) * kRadPerDeg,
          config.tilt.start_deg.value_or(config.tilt.neutral_deg) * kRadPerDeg};
}

AimOrder first_order(const PanTiltConfig& config) { return {config.follow, neutral(config)}; }

ServoAxes servo_axes(const PanTiltConfig& config) {
  ConfigProblems problems;
  check_head_axes(config, problems);
  EXPECTS(problems.list.empty());
  return {servo_axis(pan_of(config)), servo_axis(tilt_of(config))};
}

}  // namespace ninedot
