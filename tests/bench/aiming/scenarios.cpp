#include "tests/bench/aiming/scenarios.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "aim/head_kinematics.h"
#include "aim/sweep.h"
#include "base/units.h"
#include "config/head_options.h"
#include "programs/assembly/simulation_options.h"

namespace ninedot::bench {
namespace {

constexpr double kAside_mm = 1500, kHalfWay_mm = 2000, kHeight_mm = 1200;
constexpr double kStart_s = 1;  // at rest before
constexpr double kSecondsPerMs = 1e-3;

WayPointConfig place(double t_s, double x_mm) { return {t_s, x_mm, kAside_mm, kHeight_mm, -90}; }

/// Of a head that looks at the landmark from there. Looking at the wall, the robot's left is where x grows.
double pan_deg(double x_mm) { return std::atan2(-x_mm, kAside_mm) * kDegPerRad; }

void begin_at(Config& config, double at_deg) {
  config.pan_tilt.pan.neutral_deg = at_deg;
  config.simulation.servo.pan_start_deg = at_deg;
}

}  // namespace

Config base_scenario(ServoKind servo, double camera_delay_ms, double servo_delay_ms) {
  Config config;
  MapLandmarkConfig landmark;
  landmark.position_mm = {0, 0, kHeight_mm};
  config.landmarks = {landmark};
  config.pan_tilt.driver = "simulated";
  for (HeadAxisConfig* axis : {&config.pan_tilt.pan, &config.pan_tilt.tilt}) {
    axis->min_deg = -80, axis->max_deg = 80;
    axis->slew_deg_per_s = 350;
    axis->acceleration_deg_per_s2 = 4000;
  }
  config.pan_tilt.head_delay_ms = servo_delay_ms;
  config.pan_tilt.dead_band_deg = servo == ServoKind::kHobby ? 1.0 : 0.1;
  config.simulation.camera_delay_ms = camera_delay_ms;
  SimulatedServoConfig& s = config.simulation.servo;
  s.speed_deg_s = 60 / 0.17;
  s.acceleration_deg_s2 = 6000;
  s.dead_band_deg = servo == ServoKind::kHobby ? 1.0 : 0.0;
  s.resolution_deg = 0.1;
  s.delay_ms = servo_delay_ms;
  return config;
}

Config standing(Config base, double off_deg, double duration_s) {
  base.simulation.robot = {place(0, 0)};
  base.simulation.duration_s = duration_s;
  begin_at(base, off_deg);
  return base;
}

Config passing(Config base, double speed_m_s) {
  begin_at(base, pan_deg(-kHalfWay_mm));
  base.simulation.robot = {place(0, -kHalfWay_mm)};
  base.simulation.duration_s = 4;
  if (speed_m_s <= 0) return base;
  const double arrives_s = kStart_s + 2 * kHalfWay_mm * kMetresPerMm / speed_m_s;
  base.simulation.robot.push_back(place(kStart_s, -kHalfWay_mm));
  base.simulation.robot.push_back(place(arrives_s, kHalfWay_mm));
  base.simulation.duration_s = arrives_s;
  return base;
}

double passing_middle_s(double speed_m_s) { return kStart_s + kHalfWay_mm * kMetresPerMm / speed_m_s; }

Config hidden(Config scenario, double from_s, double length_s) {
  scenario.simulation.hidden.push_back({from_s, from_s + length_s});
  return scenario;
}

Config lost(Config base, double longer_s) {
  constexpr double kBegin_mm = -1700, kEnd_mm = 1700;
  begin_at(base, pan_deg(kBegin_mm));
  base.simulation.robot = {place(0, kBegin_mm), place(kLostFrom_s, kBegin_mm), place(kLostTo_s, kEnd_mm)};
  base.simulation.duration_s = kLostTo_s + longer_s + 2 * sweep_s(base) + 1;
  return hidden(base, kLostFrom_s, kLostTo_s + longer_s - kLostFrom_s);
}

double sweep_s(const Config& scenario) {
  const AimOptions options = aim_options(scenario.pan_tilt);
  const HeadKinematics kinematics(default_simulated_camera(scenario.camera), options.body);
  const Sweep sweep(options, kinematics.half_width_rad(), kinematics.half_height_rad());
  return std::chrono::duration<double>(sweep.longest()).count();
}

double unforeseeable_deg(const Config& scenario, double speed_m_s) {
  const double heard_s = 1 / scenario.camera.rate_hz +
                         kSecondsPerMs * (scenario.simulation.camera_delay_ms + scenario.simulation.servo.delay_ms);
  const double went_mm = speed_m_s * heard_s / kMetresPerMm;
  return std::abs(pan_deg(-kHalfWay_mm + went_mm) - pan_deg(-kHalfWay_mm));
}

std::vector<SimulationRow> drive(const Config& scenario, const std::optional<PidGains>& gains) {
  VirtualRunOptions options;
  if (gains) {
    options.controller = SimulatedController::kPid;
    options.pid = *gains;
  }
  VirtualRun run(scenario, default_simulated_camera(scenario.camera), options);
  std::vector<SimulationRow> rows;
  while (const std::optional<SimulationRow> row = run.next()) rows.push_back(*row);
  return rows;
}

}  // namespace ninedot::bench
