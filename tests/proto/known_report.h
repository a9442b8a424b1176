#pragma once
/// One report, metrics and server state with a different number in every place; tests/proto/register_codec_test.cpp
/// pins the registers that they make, tests/modbus/serve_main.cpp shows them to foreign clients.
#include <chrono>
#include <cmath>
#include <numbers>

#include "proto/register_codec.h"
#include "tests/proto/wire_box.h"

namespace ninedot::test {

/// \param now  the pose is 12.34 ms older
inline WireReport known_report(MonoTime now) {
  WireReport report;
  report.frames_processed = 70001;
  report.pose_sequence = 66000;
  report.frame_number = 123456;
  report.has_pose = true;
  report.sigma_calibration_mm = 1.5;
  report.exposed_at = now - std::chrono::microseconds(12340);
  report.latency_ms = 8.76;
  report.valid = report.found = report.calibrated = report.tracking = true;
  report.reason = Reason::kNone;
  report.landmark_id = 7;
  report.quality = 913;
  report.pose.position_mm = {1234.5678, -2500, 3276.7};
  // The rotation vector (0.3, -0.4, 1.2) rad, of angle 1.3.
  const double s = std::sin(0.65) / 1.3;
  report.pose.quaternion_wxyz = {std::cos(0.65), 0.3 * s, -0.4 * s, 1.2 * s};
  report.sigma_mm = {0.12, 0.34, 2.1};
  constexpr double kDegPerRad = 180 / std::numbers::pi;
  report.sigma_deg = {0.0005 * kDegPerRad, 0.001 * kDegPerRad, 0.002 * kDegPerRad};
  report.ambiguity = 0.123;
  report.rival_odds = 0.12;
  report.landmarks_seen = 3, report.landmarks_rejected = 1, report.last_rejected_id = 12;
  report.landmarks_disputed = 2, report.disputed_ids = {21, 22};
  report.rival = {{-321.5, 4000.25, 17}, {std::cos(0.65), -0.3 * s, 0.4 * s, 1.2 * s}};
  report.output = {PoseContent::kBodyInWorld, EulerConvention::kKuka};
  report.angles_deg = {123.4567, -45.25, -179.9996};
  report.sigma_angles_deg = {0.123, 0.0456, 80};
  report.rms_px = 0.0456;
  report.dots_used = 9;
  report.has_head = report.servo_limit = report.inhibited = true;
  report.pan_deg = 12.34;
  report.tilt_deg = -5.67;
  report.head_state = AimState::kCoast;
  return report;
}

/// Another number for each metric.
inline MetricValues known_metrics() {
  using enum MetricId;
  MetricValues metrics;
  metrics[kFrameRate] = 35.04;
  metrics[kFramesProcessed] = 100000;
  metrics[kFramesDropped] = 65537;
  metrics[kFramesFailed] = 3;
  metrics[kCameraRestarts] = 2;
  metrics[kLatencyMedian] = 8.7;
  metrics[kLatencyP99] = 9.5;
  metrics[kLatencyP999] = 12;
  metrics[kLatencyMax] = 33.3;
  metrics[kTemperature] = 47.26;
  metrics[kUptime] = 3661;
  metrics[kConnectedClients] = 2;
  metrics[kBusErrors] = 5;
  metrics[kExceptions] = 4;
  metrics[kRealtime] = metrics[kMemoryLocked] = 1;
  metrics[kServoSupply] = 11.93;
  metrics[kServoTemperature] = 48.5;
  metrics[kServoLoad] = 17.2;
  metrics[kPulseErrorP99] = 6.6;
  metrics[kPulseErrorMax] = 21;
  metrics[kRequests] = 4295032838.0;  // 2^32 + 65542: wraps
  metrics[kConnections] = 11;
  metrics[kConnectionsRefused] = 12;
  metrics[kConnectionsExpired] = 13;
  metrics[kForeignFrames] = 14;
  metrics[kSerialLosses] = 15;
  metrics[kSerialOpen] = 1;
  metrics[kHeadLosses] = 16;
  metrics[kRunsCut] = 17;
  metrics[kBlobsCut] = 18;
  metrics[kHypothesesCut] = 19;
  metrics[kNeighboursCut] = 20;
  metrics[kFramesCut] = 21;
  metrics[kRowTime] = 33.28;
  metrics[kRowTimeSigma] = 0.62;
  metrics[kRowTimeWrong] = 1;
  return metrics;
}

inline ServerState known_server_state(MonoTime now) {
  ServerState server;
  server.now = now;
  server.writes_enabled = true;
  server.commands.command = 2;
  server.commands.sequence = 17;
  server.commands.acknowledge = 16;
  server.commands.result = CommandResult::kRunning;
  server.commands.hold = true;
  server.commands.pan_set_point_deg = 45;
  server.commands.tilt_set_point_deg = -10;
  server.commands.client_watchdog = std::chrono::milliseconds(500);
  server.identity = {{1, 20, 300}, {'1', '0', '0', '0', '0', '0', '0', '0', 'a', '1', 'b', '2', 'c', '3', 'd'}};
  return server;
}

}  // namespace ninedot::test
