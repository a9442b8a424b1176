#include "aim/servo_axis.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {

bool ServoAxis::accepts(std::span<const AxisPoint> points) noexcept {
  if (points.size() < 2 || points.size() > kMaxPoints) return false;
  const bool rises = points[1].output > points[0].output;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const AxisPoint &a = points[i - 1], &b = points[i];
    if (!(b.angle_rad > a.angle_rad) || !(rises ? b.output > a.output : b.output < a.output)) return false;
  }
  return true;
}

ServoAxis::ServoAxis(std::span<const AxisPoint> points, double min_output, double max_output) noexcept
    : count_(points.size()), min_output_(min_output), max_output_(max_output) {
  EXPECTS(accepts(points) && min_output < max_output);
  std::ranges::copy(points, points_.begin());
}

ServoAxis::Output ServoAxis::output_at(double angle_rad) const noexcept {
  std::size_t i = 1;
  while (i + 1 < count_ && angle_rad > points_[i].angle_rad) ++i;
  const AxisPoint &a = points_[i - 1], &b = points_[i];
  const double value = a.output + (angle_rad - a.angle_rad) / (b.angle_rad - a.angle_rad) * (b.output - a.output);
  const double cut = std::clamp(value, min_output_, max_output_);
  // Rounding at a limit that was meant is no saturation.
  return {cut, std::abs(cut - value) > 1e-6 * (max_output_ - min_output_)};
}

double ServoAxis::angle_at(double output) const noexcept {
  const bool rises = points_[1].output > points_[0].output;
  std::size_t i = 1;
  while (i + 1 < count_ && (rises ? output > points_[i].output : output < points_[i].output)) ++i;
  const AxisPoint &a = points_[i - 1], &b = points_[i];
  return a.angle_rad + (output - a.output) / (b.output - a.output) * (b.angle_rad - a.angle_rad);
}

}  // namespace ninedot
