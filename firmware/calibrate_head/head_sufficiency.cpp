#include "calibrate_head/head_sufficiency.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace ninedot {
namespace {

/// Twenty numbers and more, of which an eighth of the stops at a time must be able to stay out.
constexpr std::size_t kLeastStops = 12;
constexpr double kLeastTravel_deg = kLeastTravel_rad * kDegPerRad;
/// Below it a head that never told anything, or never moved.
constexpr double kNoTravel_deg = 0.2;
/// Of what it was told: less is an axis that stands still, and what moves is the picture's noise. [1]
constexpr double kLeastTurned = 0.2;
/// A direction that is half a degree off is what a protractor gives; lengths that are 20 mm off, a folding rule.
constexpr double kMaxAngle_deg = 0.5, kMaxLength_mm = 20;

double travel_deg(const std::vector<HeadStop>& stops, double HeadAngles::*axis) {
  if (stops.empty()) return 0;
  const auto [low, high] = std::ranges::minmax(stops, {}, [&](const HeadStop& stop) { return stop.told.*axis; });
  return (high.told.*axis - low.told.*axis) * kDegPerRad;
}

void check_travel(const FoundStops& found, const char* name, double HeadAngles::*axis,
                  std::vector<std::string>& lacks) {
  const double seen_deg = travel_deg(found.stops, axis);
  if (seen_deg >= kLeastTravel_deg - kNoTravel_deg) return;
  const double all_deg = (found.told_max.*axis - found.told_min.*axis) * kDegPerRad;
  const bool lost_sight = all_deg >= kLeastTravel_deg;
  lacks.push_back(fmt::format(
      "the {} axis moved by {:.0f} degrees{}: move it by {:.0f} at least{}", name, seen_deg,
      lost_sight ? " with a landmark in sight" : "", kLeastTravel_deg,
      lost_sight ? "; a landmark that is farther away, or a second one beside it, stays in sight for longer" : ""));
}

/// The axes that hardly turn when they are told to.
std::vector<std::string> what_stands_still(const HeadCalibration& calibration) {
  std::vector<std::string> lacks;
  for (const AxisCalibration* axis : {&calibration.pan, &calibration.tilt}) {
    const auto [told_low, told_high] = std::ranges::minmax(axis->points, {}, &TablePoint::told_rad);
    const auto [low, high] = std::ranges::minmax(axis->points, {}, &TablePoint::angle_rad);
    const double told_rad = told_high.told_rad - told_low.told_rad, turned_rad = high.angle_rad - low.angle_rad;
    if (turned_rad < kLeastTurned * told_rad)
      lacks.push_back(fmt::format(
          "the {} axis turned by {:.1f} degrees where it was told {:.0f}: has it power, and do its orders reach it?",
          axis == &calibration.pan ? "pan" : "tilt", turned_rad * kDegPerRad, told_rad * kDegPerRad));
  }
  return lacks;
}

}  // namespace

std::vector<std::string> what_stops_lack(const FoundStops& found) {
  const std::size_t steady = found.stops.size();
  if (steady + found.unsteady == 0 && found.without_landmark > 0)
    return {fmt::format(
        "no landmark in sight at any of {} stops: point the head at one, near enough and whole in the picture",
        found.without_landmark)};
  const double pan_deg = (found.told_max.pan_rad - found.told_min.pan_rad) * kDegPerRad;
  const double tilt_deg = (found.told_max.tilt_rad - found.told_min.tilt_rad) * kDegPerRad;
  if (pan_deg < kNoTravel_deg && tilt_deg < kNoTravel_deg)
    return {
        "no angles of a head that moves: frames.csv must have its pan_deg and tilt_deg, as `ninedot tap --record` "
        "writes them"};
  if (steady + found.unsteady == 0) return {"the head never stood: let it stand for a second at each stop"};
  if (found.unsteady > 1 && 4 * found.unsteady > steady + found.unsteady)
    return {
        fmt::format("the landmark moved while the head stood, at {} of {} stops: keep robot and landmark where "
                    "they are, and let the head come to rest",
                    found.unsteady, steady + found.unsteady)};
  std::vector<std::string> lacks;
  check_travel(found, "pan", &HeadAngles::pan_rad, lacks);
  check_travel(found, "tilt", &HeadAngles::tilt_rad, lacks);
  if (steady < kLeastStops)
    lacks.push_back(fmt::format("{} {} with a landmark in sight {} too few: make {} at least, 40 or more are good",
                                steady, steady == 1 ? "stop" : "stops", steady == 1 ? "is" : "are", kLeastStops));
  return lacks;
}

std::vector<std::string> what_head_lacks(const HeadCalibration& calibration) {
  const std::size_t all = calibration.stops + calibration.left_out;
  if (4 * calibration.left_out > all || calibration.stops < kLeastStops)
    return {
        fmt::format("{} of {} stops contradict the others: were robot or landmarks moved in between, or does the "
                    "head slip?",
                    calibration.left_out, all)};
  // Nothing else is known of such a head, whatever is said of it.
  if (std::vector<std::string> still = what_stands_still(calibration); !still.empty()) return still;
  std::vector<std::string> lacks;
  const double length_mm =
      std::max(calibration.tilt_axis_x_sigma_m, calibration.camera_sigma_m.maxCoeff()) / kMetresPerMm;
  if (!(length_mm <= kMaxLength_mm))
    lacks.push_back(
        fmt::format("lengths are uncertain by {:.0f} mm: come nearer to the landmark, and turn the head "
                    "further",
                    length_mm));
  double angle_rad = calibration.camera_rpy_sigma_rad.maxCoeff();
  for (const AxisCalibration* axis : {&calibration.pan, &calibration.tilt})
    for (const TablePoint& point : axis->points) angle_rad = std::max(angle_rad, point.sigma_rad);
  if (!(angle_rad * kDegPerRad <= kMaxAngle_deg))
    lacks.push_back(fmt::format("angles are uncertain by {:.2g} degrees: make more stops, over all of the picture",
                                angle_rad * kDegPerRad));
  for (const AxisCalibration* axis : {&calibration.pan, &calibration.tilt})
    if (!std::ranges::is_sorted(axis->points, {}, &TablePoint::angle_rad) &&
        !std::ranges::is_sorted(axis->points, std::ranges::greater{}, &TablePoint::angle_rad))
      lacks.push_back(fmt::format("the {} axis turns back where it is told to go on: does it slip, or meet a stop?",
                                  axis == &calibration.pan ? "pan" : "tilt"));
  return lacks;
}

}  // namespace ninedot
