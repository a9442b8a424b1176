#include "outputs/wire_output.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "proto/register_codec.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr MonoTime kNow{5000s};

TEST(WireReport, HasTheReportsNumbersInMillimetresAndDegrees) {
  Report report;
  report.valid = report.found = true;
  report.reason = Reason::kNone;
  report.frames.processed = 12;
  report.latency = 8760us;
  report.process_time = 812340ns;
  report.has_pose = true;  // also at time 0, where a recording may begin
  report.exposed_at = MonoTime{};
  report.landmark_id = 3;
  report.solver = Solver::kEllipse;
  report.camera_in_landmark = {{0.5, 1.5, -0.25}, {0.5, -0.5, 0.5, -0.5}};
  report.camera_in_world = {{1.25, -2.5, 4}, {1, 0, 0, 0}};
  report.covariance[0] = 1e-6, report.covariance[7] = 4e-6, report.covariance[14] = 9e-6;
  report.covariance[21] = 1e-6, report.covariance[28] = 4e-6, report.covariance[35] = 4e-6;
  for (const auto& [axis, sigma] : {std::pair(0U, 0.001), {1U, 0.002}, {2U, 0.003}, {3U, 0.1}, {4U, 0.2}, {5U, 0.3}})
    report.covariance_world[7 * axis] = sigma * sigma;
  report.tilt_phi_rad = std::numbers::pi / 4;
  report.distance_m = 1.5;
  report.head = {true, std::numbers::pi / 8, -std::numbers::pi / 8, true, false, true, 5, OrderProgress::kRunning};
  report.landmarks_seen = 4, report.landmarks_rejected = 1, report.last_rejected_id = 7;
  report.landmarks_disputed = 2, report.disputed_ids = {8, 9};
  const WireReport wire = wire_report(report);
  EXPECT_EQ(wire.landmarks_seen, 4U);
  EXPECT_EQ(wire.landmarks_rejected, 1U);
  EXPECT_EQ(wire.last_rejected_id, 7U);
  EXPECT_EQ(wire.landmarks_disputed, 2U);
  EXPECT_EQ(wire.disputed_ids, (std::array<std::uint16_t, 2>{8, 9}));
  EXPECT_EQ(wire.frames_processed, 12U);
  EXPECT_DOUBLE_EQ(wire.latency_ms, 8.76);
  EXPECT_DOUBLE_EQ(wire.process_us, 812.34);
  EXPECT_EQ(wire.landmark_id, 3);
  EXPECT_TRUE(wire.ellipse_solver);
  EXPECT_EQ(wire.camera_in_landmark.position_mm, (std::array<double, 3>{500, 1500, -250}));
  EXPECT_EQ(wire.camera_in_landmark.quaternion_wxyz, (std::array<double, 4>{0.5, -0.5, 0.5, -0.5}));
  EXPECT_EQ(wire.pose.position_mm, (std::array<double, 3>{1250, -2500, 4000}));
  EXPECT_DOUBLE_EQ(wire.sigma_landmark_mm[2], 3);
  EXPECT_DOUBLE_EQ(wire.sigma_rotation_deg, 0.003 * 180 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(wire.sigma_mm[1], 2);
  EXPECT_DOUBLE_EQ(wire.sigma_deg[0], 18 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(wire.tilt_phi_deg, 45);
  EXPECT_DOUBLE_EQ(wire.distance_mm, 1500);
  EXPECT_TRUE(wire.has_head && wire.servo_limit && wire.inhibited && !wire.servo_fault);
  EXPECT_DOUBLE_EQ(wire.pan_deg, 22.5);
  EXPECT_DOUBLE_EQ(wire.tilt_deg, -22.5);
}

TEST(WireReport, KnowsNothingOfAPoseBeforeTheFirst) {
  const WireReport wire = wire_report(Report{});
  for (const double mm : wire.pose.position_mm) EXPECT_TRUE(std::isnan(mm));
  for (const double q : wire.pose.quaternion_wxyz) EXPECT_TRUE(std::isnan(q));
  for (const double sigma : wire.sigma_mm) EXPECT_TRUE(std::isnan(sigma));
  EXPECT_TRUE(std::isnan(wire.latency_ms));
  EXPECT_EQ(wire.landmark_id, kNoLandmarkYet);
}

TEST(FrameMetrics, TakeTheFramesFromTheReportAndTheRestFromTheHealth) {
  Report report;
  report.frames = {100, 7, 2, {1, 2, 3, 4, 5}};
  Health health;
  health.started_at = kNow - 3661900ms;
  health.frame_rate_hz = 35;
  health.rate_holds_until = kNow;
  health.frames_flagged = 5;
  health.head_losses = 9;
  health.pulse_error_p99 = 6600ns;
  health.servos = {.load_percent = 14, .supply_V = 11.9, .temperature_degC = 48};
  const MetricValues metrics = frame_metrics(report, health, kNow);
  EXPECT_EQ(metrics[MetricId::kFramesProcessed], 100);
  EXPECT_EQ(metrics[MetricId::kFramesDropped], 7);
  EXPECT_EQ(metrics[MetricId::kFramesFailed], 7) << "two that the loop refused, five that the camera itself did";
  EXPECT_EQ(metrics[MetricId::kFrameRate], 35);
  EXPECT_EQ(metrics[MetricId::kUptime], 3661);
  EXPECT_EQ(metrics[MetricId::kHeadLosses], 9);
  EXPECT_DOUBLE_EQ(metrics[MetricId::kPulseErrorP99], 6.6);
  EXPECT_EQ(metrics[MetricId::kServoLoad], 14);
  EXPECT_EQ(metrics[MetricId::kServoSupply], 11.9);
  EXPECT_EQ(metrics[MetricId::kServoTemperature], 48);
  EXPECT_EQ(metrics[MetricId::kRunsCut], 1);
  EXPECT_EQ(metrics[MetricId::kBlobsCut], 2);
  EXPECT_EQ(metrics[MetricId::kNeighboursCut], 3);
  EXPECT_EQ(metrics[MetricId::kHypothesesCut], 4);
  EXPECT_EQ(metrics[MetricId::kFramesCut], 5);
  EXPECT_TRUE(std::isnan(metrics[MetricId::kLatencyMedian])) << "no frame has been measured yet";
}

TEST(WireOutput, HeartbeatAndProcessedFramesOfOneReplyAreOfOneReport) {
  Mailbox<Report> reports;
  const Mailbox<Health> health;
  const WireOutput output(reports, health);
  for (std::uint32_t n = 65530; n < 65545; ++n) {
    Report report;
    report.frames.processed = n;
    reports.publish(report);
    const WireState state = output.read(kNow);
    const RegisterBlock block = encode_registers(state.report, state.metrics, {}, {});
    EXPECT_EQ(block[reg::kHeartbeat], block[reg::kFramesProcessed + 1]);
    EXPECT_EQ(RegisterReader(block).integer(reg::kFramesProcessed), n);
  }
}

}  // namespace
}  // namespace ninedot
