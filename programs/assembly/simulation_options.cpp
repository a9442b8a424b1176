#include "programs/assembly/simulation_options.h"

#include <chrono>
#include <cmath>
#include <functional>

#include "base/startup_error.h"
#include "base/units.h"
#include "config/head_options.h"

namespace ninedot {
namespace {

std::chrono::nanoseconds from_ms(double ms) { return std::chrono::nanoseconds(std::llround(ms * 1e6)); }

Eigen::Vector3d scaled(const std::array<double, 3>& values, double unit) {
  return unit * Eigen::Vector3d(values[0], values[1], values[2]);
}

/// Of paint from a laser printer, linear: sRGB (190, 40, 50), (40, 140, 70), (40, 70, 160); toner's black.
Reflectance reflectance_of(char letter) {
  switch (letter) {
    case 'R':
      return {0.515F, 0.021F, 0.032F};
    case 'G':
      return {0.021F, 0.262F, 0.061F};
    case 'B':
      return {0.021F, 0.061F, 0.352F};
    default:
      return {0.04F, 0.04F, 0.04F};
  }
}

Eigen::Isometry3d place_of(const MapLandmarkConfig& landmark) {
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  if (landmark.position_mm) place.translation() = scaled(*landmark.position_mm, kMetresPerMm);
  if (landmark.orientation_wxyz) {
    const auto& [w, x, y, z] = *landmark.orientation_wxyz;
    place.linear() = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  } else {
    place.linear() = Eigen::AngleAxisd(landmark.heading_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  return place;
}

HungSheet hung_sheet(const LandmarkConfig& shared, const MapLandmarkConfig& landmark) {
  HungSheet sheet;
  sheet.ring_radius_m = shared.ring_radius_mm * kMetresPerMm;
  sheet.dot_radius_m = shared.dot_diameter_mm / 2 * kMetresPerMm;
  sheet.centre_radius_m = shared.centre_diameter_mm / 2 * kMetresPerMm;
  // As `ninedot pattern` prints it: nearly a dot's radius of white around the ring.
  sheet.half_side_m = sheet.ring_radius_m + (1 + 12.3 / 12.7) * sheet.dot_radius_m;
  sheet.T_world_sheet = place_of(landmark);
  for (std::size_t i = 0; i < sheet.inks.size(); ++i)
    sheet.inks[i] = reflectance_of(i < landmark.code.size() ? landmark.code[i] : 'K');
  return sheet;
}

/// Those that have a place; a lone one without hangs at the world's origin.
std::vector<HungSheet> hung_sheets(const Config& config) {
  std::vector<MapLandmarkConfig> landmarks = config.landmarks;
  if (landmarks.empty()) landmarks.emplace_back();
  std::vector<HungSheet> sheets;
  for (const MapLandmarkConfig& landmark : landmarks)
    if (landmark.position_mm || landmarks.size() == 1) sheets.push_back(hung_sheet(config.landmark, landmark));
  return sheets;
}

ServoDynamics servo_dynamics(const SimulatedServoConfig& servo, const HeadAxisConfig& axis) {
  return {.min_rad = axis.min_deg * kRadPerDeg,
          .max_rad = axis.max_deg * kRadPerDeg,
          .speed_rad_s = servo.speed_deg_s * kRadPerDeg,
          .acceleration_rad_s2 = servo.acceleration_deg_s2 * kRadPerDeg,
          .dead_band_rad = servo.dead_band_deg * kRadPerDeg,
          .backlash_rad = servo.backlash_deg * kRadPerDeg,
          .resolution_rad = servo.resolution_deg * kRadPerDeg,
          .delay = from_ms(servo.delay_ms)};
}

HeadMount true_mount(const BodyConfig& said, const SimulatedHeadConfig& head) {
  return {scaled(said.pan_axis_mm, kMetresPerMm), scaled(said.mount_rpy_deg, kRadPerDeg),
          scaled(head.tilt_axis_mm.value_or(said.tilt_axis_mm), kMetresPerMm),
          scaled(head.camera_mm.value_or(said.camera_mm), kMetresPerMm),
          scaled(head.camera_rpy_deg.value_or(said.camera_rpy_deg), kRadPerDeg)};
}

/// What is told becomes a pulse as [pan_tilt] has it, and the pulse an angle as the head truly has it.
std::function<HeadAngles(const HeadAngles&)> true_angles(const Config& config) {
  const SimulatedHeadConfig& head = config.simulation.head;
  if (head.pan_calibration.empty() && head.tilt_calibration.empty()) return {};
  const auto truth = [](const std::vector<AxisPoint>& points, const ServoAxis& said) {
    constexpr double kEndless_us = 1e6;
    return points.empty() ? said : ServoAxis(points, -kEndless_us, kEndless_us);
  };
  const ServoAxes said = servo_axes(config.pan_tilt);
  return [said, pan = truth(head.pan_calibration, said.pan),
          tilt = truth(head.tilt_calibration, said.tilt)](const HeadAngles& told) {
    return HeadAngles{pan.angle_at(said.pan.output_at(told.pan_rad).value),
                      tilt.angle_at(said.tilt.output_at(told.tilt_rad).value)};
  };
}

}  // namespace

CameraModel default_simulated_camera(const CameraConfig& config) {
  CameraModel camera;
  camera.width_px = config.width_px;
  camera.height_px = config.height_px;
  camera.fx_px = camera.fy_px = 720.0 * config.width_px / 640;
  camera.cx_px = (config.width_px - 1) / 2.0;
  camera.cy_px = (config.height_px - 1) / 2.0;
  return camera;
}

SimulationOptions simulation_options(const Config& config, const CameraModel& camera, std::uint64_t seed) {
  const SimulationConfig& simulation = config.simulation;
  if (simulation.robot.empty())
    throw StartupError(ExitStatus::kWrongUsage, "there is no robot: write [[simulation.robot]], where it is and when");
  SimulationOptions options;
  options.camera = camera;
  options.sheets = hung_sheets(config);
  if (options.sheets.empty())
    throw StartupError(ExitStatus::kWrongUsage, "no landmark has a place: write position_mm in [[landmarks]]");
  for (const WayPointConfig& point : simulation.robot)
    options.robot.push_back({point.t_s, kMetresPerMm * Eigen::Vector3d(point.x_mm, point.y_mm, point.z_mm),
                             point.heading_deg * kRadPerDeg});
  for (const HiddenConfig& hidden : simulation.hidden) options.hidden.push_back({hidden.from_s, hidden.to_s});
  options.mount = true_mount(config.body, simulation.head);
  options.pan = servo_dynamics(simulation.servo, config.pan_tilt.pan);
  options.tilt = servo_dynamics(simulation.servo, config.pan_tilt.tilt);
  options.start = {simulation.servo.pan_start_deg * kRadPerDeg, simulation.servo.tilt_start_deg * kRadPerDeg};
  options.true_angles = true_angles(config);
  options.rate_hz = config.camera.rate_hz;
  options.duration_s = simulation.duration_s;
  options.camera_delay = from_ms(simulation.camera_delay_ms);
  options.renderer = {simulation.blur_px, simulation.noise_lsb, seed, config.camera.row_time_us.value_or(0) * 1e-6,
                      config.camera.exposure_us * 1e-6};
  return options;
}

SimulationClock& machine_clock() {
  static MachineClock clock;
  return clock;
}

}  // namespace ninedot
