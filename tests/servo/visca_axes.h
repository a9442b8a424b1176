#pragma once
/// The axes of an EVI-D31 over its whole range.
#include <array>
#include <numbers>

#include "aim/evi_d31.h"
#include "aim/servo_axis.h"

namespace ninedot::test {

/// \param end_steps  where the axis stands at +max_deg
inline ServoAxis symmetric_axis(double max_deg, int end_steps) noexcept {
  const double max_rad = max_deg * std::numbers::pi / 180;
  const std::array<AxisPoint, 2> points = {
      {{-max_rad, static_cast<double>(-end_steps)}, {max_rad, static_cast<double>(end_steps)}}};
  const double limit = end_steps < 0 ? -end_steps : end_steps;
  return {points, -limit, limit};
}

/// The camera's whole range. Our pan is positive to the left, the camera's to the right.
inline ServoAxes evi_d31_axes() noexcept {
  return {symmetric_axis(kEviD31MaxPan_deg, -kEviD31MaxPanSteps),
          symmetric_axis(kEviD31MaxTilt_deg, kEviD31MaxTiltSteps)};
}

}  // namespace ninedot::test
