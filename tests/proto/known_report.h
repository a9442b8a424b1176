#pragma once
/// One report, health and server state with a different number in every place; tests/proto/register_codec_test.cpp pins
/// the registers that they make, tests/modbus/serve_main.cpp shows them to foreign clients.
#include <chrono>
#include <cmath>
#include <numbers>

#include "proto/register_codec.h"
#include "proto/report.h"

namespace ninedot::test {

/// \param now  the pose is 12.34 ms older
inline Report known_report(MonoTime now) {
  constexpr double kRadPerDeg = std::numbers::pi / 180;
  Report report;
  report.heartbeat = 70001;
  report.pose_sequence = 66000;
  report.frame_number = 123456;
  report.exposed_at = now - std::chrono::microseconds(12340);
  report.published_at = now - std::chrono::microseconds(3580);
  report.latency = std::chrono::microseconds(8760);
  report.valid = report.found = report.calibrated = report.tracking = true;
  report.reason = Reason::kNone;
  report.landmark_id = 7;
  report.quality = 913;
  report.camera_in_world.position_m = {1.2345678, -2.5, 3.2767};
  // The rotation vector (0.3, -0.4, 1.2) rad, of angle 1.3.
  const double s = std::sin(0.65) / 1.3;
  report.camera_in_world.quaternion_wxyz = {std::cos(0.65), 0.3 * s, -0.4 * s, 1.2 * s};
  report.sigma_world = {0.00012, 0.00034, 0.0021, 0.0005, 0.001, 0.002};
  report.ambiguity = 0.123;
  report.rms_px = 0.0456;
  report.dots_used = 9;
  report.has_head = report.servo_limit = report.inhibited = true;
  report.pan_rad = 12.34 * kRadPerDeg;
  report.tilt_rad = -5.67 * kRadPerDeg;
  return report;
}

/// \param now  the service started 3661.9 s before
inline Health known_health(MonoTime now) {
  using std::chrono::microseconds;
  Health health;
  health.started_at = now - std::chrono::milliseconds(3661900);
  health.frame_rate_hz = 35.04;
  health.frames_processed = 100000;
  health.frames_dropped = 65537;
  health.frames_failed = 3;
  health.camera_restarts = 2;
  health.latency_median = microseconds(8700);
  health.latency_p99 = microseconds(9500);
  health.latency_p999 = microseconds(12000);
  health.latency_max = microseconds(33300);
  health.pulse_error_p99 = std::chrono::nanoseconds(6600);
  health.pulse_error_max = microseconds(21);
  health.temperature_degC = 47.26;
  health.realtime = health.memory_locked = true;
  return health;
}

inline ServerState known_server_state(MonoTime now) {
  ServerState server;
  server.now = now;
  server.writes_enabled = true;
  server.connected_clients = 2;
  server.bus_errors = 5;
  server.exceptions = 4;
  server.commands.command = 2;
  server.commands.sequence = 17;
  server.commands.acknowledge = 16;
  server.commands.result = CommandResult::kRunning;
  server.commands.hold = true;
  server.commands.pan_set_point_deg = 45;
  server.commands.tilt_set_point_deg = -10;
  server.commands.client_watchdog = std::chrono::milliseconds(500);
  return server;
}

}  // namespace ninedot::test
