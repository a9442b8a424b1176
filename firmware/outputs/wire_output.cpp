#include "outputs/wire_output.h"

#include <cmath>

#include <Eigen/Geometry>

#include "base/units.h"
#include "outputs/told_angles.h"

namespace ninedot {
namespace {

constexpr double kMmPerM = 1000;

std::array<double, 3> scaled(const double* xyz, double factor) noexcept {
  return {xyz[0] * factor, xyz[1] * factor, xyz[2] * factor};
}

WirePose wire_pose(const ReportPose& pose) noexcept {
  return {scaled(pose.position_m.data(), kMmPerM), pose.quaternion_wxyz};
}

double ms_of(std::chrono::nanoseconds duration) noexcept { return static_cast<double>(duration.count()) * 1e-6; }

/// Of one of the three poses that a report knows. Covariances are of (position in its frame, rotation in its own axes).
struct ChosenPose {
  const ReportPose& pose;
  const std::array<double, 36>& covariance;
  const ReportPose& rival;
};

ChosenPose chosen_pose(const Report& report, PoseContent content) noexcept {
  switch (content) {
    case PoseContent::kCameraInLandmark:
      return {report.camera_in_landmark, report.covariance, report.rival.camera_in_landmark};
    case PoseContent::kBodyInWorld:
      return {report.body_in_world, report.covariance_body, report.rival.body_in_world};
    case PoseContent::kCameraInWorld:
      break;
  }
  return {report.camera_in_world, report.covariance_world, report.rival.camera_in_world};
}

void fill_chosen(const ChosenPose& chosen, WireReport& wire) noexcept {
  const auto& [w, x, y, z] = chosen.pose.quaternion_wxyz;
  const Eigen::Matrix3d R = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
  const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> covariance(chosen.covariance.data());
  const Eigen::Matrix3d rotation = covariance.bottomRightCorner<3, 3>(), about_axes = R * rotation * R.transpose();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<Eigen::Index>(axis);
    wire.sigma_mm[axis] = std::sqrt(covariance(at, at)) * kMmPerM;
    wire.sigma_deg[axis] = std::sqrt(about_axes(at, at)) * kDegPerRad;
  }
  const ToldAngles told = told_angles(R, rotation, wire.output.euler);
  wire.pose = wire_pose(chosen.pose);
  wire.angles_deg = told.angles_deg;
  wire.sigma_angles_deg = told.sigma_deg;
}

void fill_pose(const Report& report, WireReport& wire) noexcept {
  const auto variance = [&report](std::size_t axis) { return report.covariance[7 * axis]; };
  wire.has_pose = true;
  wire.exposed_at = report.exposed_at;
  wire.landmark_id = report.landmark_id;
  wire.camera_in_landmark = wire_pose(report.camera_in_landmark);
  for (std::size_t axis = 0; axis < 3; ++axis) wire.sigma_landmark_mm[axis] = std::sqrt(variance(axis)) * kMmPerM;
  wire.sigma_rotation_deg = std::sqrt(variance(3) + variance(4) + variance(5)) * kDegPerRad;
  wire.sigma_calibration_landmark_mm = report.calibration_sigma_m * kMmPerM;
  wire.sigma_calibration_mm =
      (wire.output.content == PoseContent::kCameraInLandmark ? report.calibration_sigma_m
                                                             : report.calibration_sigma_world_m) *
      kMmPerM;
  wire.ambiguity = report.ambiguity;
  wire.rms_px = report.rms_px;
  wire.dots_used = report.dots_used;
  wire.occlusion_level = report.occlusion_level;
  wire.swing_psi_deg = report.swing_psi_rad * kDegPerRad;
  wire.tilt_phi_deg = report.tilt_phi_rad * kDegPerRad;
  wire.pan_theta_deg = report.pan_theta_rad * kDegPerRad;
  wire.distance_mm = report.distance_m * kMmPerM;
}

}  // namespace

WireReport wire_report(const Report& report, const PoseOutput& output) noexcept {
  const ChosenPose chosen = chosen_pose(report, output.content);
  WireReport wire;
  wire.output = output;
  wire.frames_processed = report.frames.processed;
  wire.pose_sequence = report.pose_sequence;
  wire.frame_number = report.frame_number;
  if (report.frames.processed != 0) wire.latency_ms = ms_of(report.latency);
  wire.process_us = static_cast<double>(report.process_time.count()) / 1000;
  wire.valid = report.valid;
  wire.found = report.found;
  wire.ambiguous = report.ambiguous;
  wire.calibrated = report.calibrated;
  wire.tracking = report.tracking;
  wire.ellipse_solver = report.solver == Solver::kEllipse;
  wire.reason = report.reason;
  wire.quality = report.quality;
  wire.rival_odds = report.rival.odds;
  if (report.rival.odds > 0) {
    wire.rival_in_landmark = wire_pose(report.rival.camera_in_landmark);
    wire.rival = wire_pose(chosen.rival);
  }
  wire.landmarks_seen = report.landmarks_seen;
  wire.landmarks_rejected = report.landmarks_rejected;
  wire.last_rejected_id = report.last_rejected_id;
  wire.landmarks_disputed = report.landmarks_disputed;
  wire.disputed_ids = report.disputed_ids;
  if (report.has_pose) fill_pose(report, wire);
  if (report.has_pose) fill_chosen(chosen, wire);
  wire.has_head = report.head.present;
  wire.servo_limit = report.head.limited;
  wire.servo_fault = report.head.failed;
  wire.inhibited = report.head.inhibited;
  wire.pan_deg = report.head.pan_rad * kDegPerRad;
  wire.tilt_deg = report.head.tilt_rad * kDegPerRad;
  wire.head_state = report.head.state;
  return wire;
}

MetricValues frame_metrics(const Report& report, const Health& health, MonoTime now) noexcept {
  MetricValues out;
  const auto latency_ms = [&health](std::chrono::nanoseconds value) {
    return health.has_latency ? ms_of(value) : kUnknown;
  };
  out[MetricId::kFrameRate] = now <= health.rate_holds_until ? health.frame_rate_hz : 0;
  out[MetricId::kFramesProcessed] = report.frames.processed;
  out[MetricId::kFramesDropped] = report.frames.dropped;
  out[MetricId::kFramesFailed] = report.frames.failed + health.frames_flagged;
  out[MetricId::kCameraRestarts] = health.camera_restarts;
  out[MetricId::kLatencyMedian] = latency_ms(health.latency_median);
  out[MetricId::kLatencyP99] = latency_ms(health.latency_p99);
  out[MetricId::kLatencyP999] = latency_ms(health.latency_p999);
  out[MetricId::kLatencyMax] = latency_ms(health.latency_max);
  const bool started = health.started_at != MonoTime{};
  out[MetricId::kUptime] = started ? std::floor(ms_of(now - health.started_at) * 1e-3) : 0.0;
  out[MetricId::kRealtime] = health.realtime ? 1 : 0;
  out[MetricId::kMemoryLocked] = health.memory_locked ? 1 : 0;
  out[MetricId::kTemperature] = health.temperature_degC;
  out[MetricId::kHeadLosses] = health.head_losses;
  out[MetricId::kServoSupply] = health.servos.supply_V;
  out[MetricId::kServoTemperature] = health.servos.temperature_degC;
  out[MetricId::kServoLoad] = health.servos.load_percent;
  out[MetricId::kPulseErrorP99] = ms_of(health.pulse_error_p99) * 1e3;
  out[MetricId::kPulseErrorMax] = ms_of(health.pulse_error_max) * 1e3;
  const WorkCounts& work = report.frames.work;
  out[MetricId::kRunsCut] = work.runs_cut;
  out[MetricId::kBlobsCut] = work.blobs_cut;
  out[MetricId::kHypothesesCut] = work.hypotheses_cut;
  out[MetricId::kNeighboursCut] = work.neighbours_cut;
  out[MetricId::kFramesCut] = work.frames_cut;
  const RowTime& rows = report.row_time;
  const bool is_known = rows.source != RowTimeSource::kOpen;
  out[MetricId::kRowTime] = is_known ? rows.mean_s * 1e6 : kUnknown;
  out[MetricId::kRowTimeSigma] = is_known ? rows.sigma_s * 1e6 : kUnknown;
  out[MetricId::kRowTimeWrong] = rows.source == RowTimeSource::kContradicted ? 1 : 0;
  return out;
}

WireState WireOutput::read(MonoTime now) const noexcept {
  const Report report = reports_.read();
  return {wire_report(report, output_), frame_metrics(report, health_.read(), now)};
}

}  // namespace ninedot
