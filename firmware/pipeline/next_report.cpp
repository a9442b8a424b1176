#include "pipeline/next_report.h"

#include "pipeline/report_reason.h"

namespace ninedot {
namespace {

ReportPose report_pose(const Eigen::Vector3d& position_m, const Eigen::Quaterniond& q) noexcept {
  return {{position_m.x(), position_m.y(), position_m.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

void fill_pose(const LandmarkFix& fix, Report& report) noexcept {
  const PoseEstimate& pose = fix.pose();
  report.camera_in_landmark = report_pose(pose.T_landmark_camera.translation_m, pose.T_landmark_camera.quaternion());
  report.camera_in_world = report_pose(fix.T_world_camera.translation_m, fix.T_world_camera.quaternion());
  for (Eigen::Index row = 0; row < 6; ++row)
    for (Eigen::Index column = 0; column < 6; ++column)
      report.covariance[static_cast<std::size_t>(6 * row + column)] = pose.covariance(row, column);
  report.sigma_world = fix.sigma_world;
  report.landmark_id = fix.id;
  report.quality = fix.quality;
  report.ambiguity = pose.ambiguity;
  report.ambiguous = fix.ambiguous;
  report.rms_px = pose.rms_px;
  report.dots_used = static_cast<std::uint16_t>(pose.dots_used);
  report.occlusion_level = static_cast<std::uint16_t>(pose.occlusion_level);
  report.swing_psi_rad = pose.ellipse.swing_psi_rad;
  report.tilt_phi_rad = pose.ellipse.tilt_phi_rad;
  report.pan_theta_rad = pose.ellipse.pan_theta_rad;
  report.distance_m = pose.ellipse.distance_m;
  report.image_distance_m = pose.ellipse.image_distance_m;
  report.deviation_rad = pose.ellipse.deviation_rad;
}

}  // namespace

Report next_report(const Report& before, const Frame& frame, const Fix& fix) noexcept {
  Report report = before;
  ++report.heartbeat;
  report.frame_number = frame.number;
  report.calibrated = fix.calibrated;
  report.solver = fix.solver;
  if (fix.reason == Reason::kNone) {
    fill_pose(fix.main(), report);
    report.exposed_at = frame.exposed_at();
    ++report.pose_sequence;
    report.valid = true;
    report.reason = Reason::kNone;
  } else {
    mark_invalid(fix.reason, report);
  }
  report.found = fix.found;
  report.tracking = fix.tracked;
  report.process_time = fix.process_time;
  const HeadAngles head = frame.head.value_or(HeadAngles{});
  report.pan_rad = head.pan_rad;
  report.tilt_rad = head.tilt_rad;
  return report;
}

}  // namespace ninedot
