#include "programs/commands/head_file_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/one_line.h"
#include "base/startup_error.h"
#include "base/units.h"
#include "config/head_options.h"

namespace ninedot {
namespace {

/// Knots that are so near to a corner of the old table add nothing.
constexpr double kSamePoint_rad = 0.3 * kRadPerDeg;
/// Below it, and below three sigma, axes count as square: no workshop does better.
constexpr double kSquare_rad = 0.1 * kRadPerDeg;

std::string three(const Eigen::Vector3d& values, double unit, int digits) {
  return fmt::format("[{:.{}f}, {:.{}f}, {:.{}f}]", values.x() / unit, digits, values.y() / unit, digits,
                     values.z() / unit, digits);
}

std::string three(const std::array<double, 3>& values) {
  return fmt::format("[{:g}, {:g}, {:g}]", values[0], values[1], values[2]);
}

std::string play_text(const AxisCalibration& axis) {
  if (!axis.sees_play) return "play unknown: it came from one side only";
  return fmt::format("play {:.3f} +- {:.2g} deg", axis.play_rad * kDegPerRad, axis.play_sigma_rad * kDegPerRad);
}

std::string sigma_line(const char* key, const AxisCalibration& axis, double before_deg) {
  return fmt::format("{} = {:.4f}  # spread {:.3f} deg, {}; was {:g}\n", key, axis.sigma_rad * kDegPerRad,
                     axis.spread_rad * kDegPerRad, play_text(axis), before_deg);
}

std::string body_text(const HeadCalibration& head, const BodyConfig& before) {
  const BodyGeometry& body = head.body;
  return fmt::format(
             "[body]\n"
             "tilt_axis_mm = {}  # 1-sigma {:.2g} mm in x; y and z as they were, no camera sees them; was {}\n"
             "camera_mm = {}  # 1-sigma {} mm; was {}\n"
             "camera_rpy_deg = {}  # 1-sigma {} deg; was {}\n",
             three(body.tilt_axis_m, kMetresPerMm, 3), head.tilt_axis_x_sigma_m / kMetresPerMm,
             three(before.tilt_axis_mm), three(body.camera_m, kMetresPerMm, 3),
             three(head.camera_sigma_m, kMetresPerMm, 2), three(before.camera_mm),
             three(body.camera_rpy_rad, kRadPerDeg, 4), three(head.camera_rpy_sigma_rad, kRadPerDeg, 3),
             three(before.camera_rpy_deg)) +
         sigma_line("pan_sigma_deg", head.pan, before.pan_sigma_deg) +
         sigma_line("tilt_sigma_deg", head.tilt, before.tilt_sigma_deg);
}

double sigma_at(const AxisCalibration& axis, double told_rad) {
  const auto* const nearest = &*std::ranges::min_element(
      axis.points, {}, [&](const TablePoint& point) { return std::abs(point.told_rad - told_rad); });
  return nearest->sigma_rad;
}

std::string axis_text(const char* name, const AxisCalibration& axis, const HeadAxisConfig& config,
                      const ServoAxis& said, const char* unit) {
  std::vector<double> corners;
  for (const AxisPoint& point : config.calibration) corners.push_back(point.angle_rad);
  const std::vector<AxisPoint> points = corrected_table(axis, said, corners);
  if (points.empty())
    throw StartupError(
        ExitStatus::kWorkFailed,
        fmt::format("the {} axis turns back where it is told to go on: does it slip, or meet a stop?", name));
  std::string text = fmt::format(
      "\n[pan_tilt.{}]  # told {:.1f} to {:.1f} deg were travelled\n"
      "calibration = [  # [deg, {}]; in place of direction, centre_us and us_per_deg\n",
      name, axis.points.front().told_rad * kDegPerRad, axis.points.back().told_rad * kDegPerRad, unit);
  for (const AxisPoint& point : points) {
    const double told_rad = said.angle_at(point.output);
    text += fmt::format("  [{:.4f}, {:.3f}],  # +- {:.2g} deg; was {:.3f}\n", point.angle_rad * kDegPerRad,
                        point.output, sigma_at(axis, told_rad) * kDegPerRad, told_rad * kDegPerRad);
  }
  return text + "]\n";
}

double angle_at(const AxisCalibration& axis, double told_rad) {
  AngleTable table;
  for (const TablePoint& point : axis.points) {
    table.told_rad.push_back(point.told_rad);
    table.angle_rad.push_back(point.angle_rad);
  }
  return table.at(told_rad);
}

bool counts_steps(const std::string& driver) {
  return driver == "visca" || driver == "dynamixel" || driver == "feetech-sts" || driver == "feetech-scs";
}

}  // namespace

std::vector<AxisPoint> corrected_table(const AxisCalibration& axis, const ServoAxis& said,
                                       const std::vector<double>& corners) {
  const double from = axis.points.front().told_rad, to = axis.points.back().told_rad;
  std::vector<double> told;
  for (const double corner : corners)
    if (corner > from + kSamePoint_rad && corner < to - kSamePoint_rad) told.push_back(corner);
  // Both ends must be in it; of the longest table those beside them make room.
  if (told.size() + 2 > ServoAxis::kMaxPoints) told.erase(told.begin());
  if (told.size() + 2 > ServoAxis::kMaxPoints) told.pop_back();
  const bool has_room = told.size() + axis.points.size() <= ServoAxis::kMaxPoints;
  for (std::size_t i = 0; i < axis.points.size(); ++i) {
    const bool is_end = i == 0 || i + 1 == axis.points.size();
    const double knot = axis.points[i].told_rad;
    const bool is_double =
        std::ranges::any_of(told, [&](double other) { return std::abs(other - knot) < kSamePoint_rad; });
    if (is_end || (has_room && !is_double)) told.push_back(knot);
  }
  std::vector<AxisPoint> points;
  for (const double told_rad : told) points.push_back({angle_at(axis, told_rad), said.output_at(told_rad).value});
  std::ranges::sort(points, {}, &AxisPoint::angle_rad);
  return ServoAxis::accepts(points) ? points : std::vector<AxisPoint>{};
}

std::string head_file_text(const HeadCalibration& head, const Config& before, const std::string& source) {
  std::string text = fmt::format("# Made by `ninedot calibrate pan-tilt` from {}.\n", one_line(source));
  for (const std::string& line : head_summary(head)) text += fmt::format("# {}\n", line);
  text += "# Each angle is zero where it was before. What follows takes the place of the keys of these sections.\n" +
          body_text(head, before.body);
  if (before.pan_tilt.driver == "none") return text + "# No tables: pan_tilt.driver is \"none\".\n";
  const ServoAxes said = servo_axes(before.pan_tilt);
  const char* const unit = counts_steps(before.pan_tilt.driver) ? "steps" : "us";
  return text + axis_text("pan", head.pan, before.pan_tilt.pan, said.pan, unit) +
         axis_text("tilt", head.tilt, before.pan_tilt.tilt, said.tilt, unit);
}

std::vector<std::string> head_summary(const HeadCalibration& head) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{} stops before {} landmark{}, {} left out; pictures off by {:.2g} times what they say",
                              head.stops, head.landmarks, head.landmarks == 1 ? "" : "s", head.left_out,
                              std::sqrt(head.variance_factor)));
  for (const auto& [name, axis] : {std::pair<const char*, const AxisCalibration&>{"pan", head.pan},
                                   std::pair<const char*, const AxisCalibration&>{"tilt", head.tilt}})
    lines.push_back(
        fmt::format("{}: told {:.1f} to {:.1f} deg are {:.2f} to {:.2f}, in {} points; spread {:.3f} deg, {}", name,
                    axis.points.front().told_rad * kDegPerRad, axis.points.back().told_rad * kDegPerRad,
                    axis.points.front().angle_rad * kDegPerRad, axis.points.back().angle_rad * kDegPerRad,
                    axis.points.size(), axis.spread_rad * kDegPerRad, play_text(axis)));
  lines.push_back(
      fmt::format("directions foretold to {:.3f} deg rms at stops that the fit left out; to {:.3f} deg "
                  "before",
                  head.foretold_rad * kDegPerRad, head.foretold_before_rad * kDegPerRad));
  if (std::abs(head.skew_rad) > std::max(kSquare_rad, 3 * head.skew_sigma_rad))
    lines.push_back(
        fmt::format("the axes are {:.2f} +- {:.2g} deg off square, which [body] cannot say: that is part of "
                    "the spreads",
                    head.skew_rad * kDegPerRad, head.skew_sigma_rad * kDegPerRad));
  return lines;
}

}  // namespace ninedot
