#include "pipeline/next_report.h"

#include <algorithm>

#include "base/contract.h"

namespace ninedot {
namespace {

template <typename From, typename To>
ReportPose report_pose(const Transform<From, To>& T) noexcept {
  const Eigen::Quaterniond q = T.quaternion();
  return {{T.translation_m.x(), T.translation_m.y(), T.translation_m.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

void fill(const Eigen::Matrix<double, 6, 6>& covariance, std::array<double, 36>& rows) noexcept {
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(rows.data()) = covariance;
}

void fill_pose(const LandmarkFix& fix, const CameraOnBody& camera, Report& report) noexcept {
  const PoseEstimate& pose = fix.pose();
  const BodyPose body = body_in_world(fix.T_world_camera, fix.covariance_world, camera);
  report.camera_in_landmark = report_pose(pose.T_landmark_camera);
  report.camera_in_world = report_pose(fix.T_world_camera);
  report.body_in_world = report_pose(body.T_world_body);
  fill(pose.covariance, report.covariance);
  fill(fix.covariance_world, report.covariance_world);
  fill(body.covariance, report.covariance_body);
  report.calibration_sigma_m = fix.calibration_sigma_m;
  report.calibration_sigma_world_m = fix.calibration_sigma_world_m;
  report.landmark_id = fix.id;
  report.quality = fix.quality;
  report.ambiguity = pose.ambiguity;
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

void fill_rival(const LandmarkFix& fix, const CameraOnBody& camera, Report& report) noexcept {
  report.rival = {};
  if (!fix.candidates.rival) return;
  const auto& T = fix.candidates.rival->T_landmark_camera;
  const auto T_world = fix.T_world_camera * fix.pose().T_landmark_camera.inverse() * T;
  // A map that has decided knows more than this sheet alone, of which the rival's odds are.
  const double odds = std::min(fix.candidates.rival->odds, fix.pose().ambiguity);
  report.rival = {odds, report_pose(T), report_pose(T_world), report_pose(T_world * camera.T_body_camera.inverse())};
}

/// When the frame was exposed.
CameraOnBody mounted_at(const Frame& frame, const ReportContext& context) noexcept {
  const HeadAngles recorded = frame.head.value_or(HeadAngles{});
  const HeadAngles head = context.head != nullptr ? context.head->track.at(frame.exposed_at()) : recorded;
  return camera_on_body(context.body != nullptr ? *context.body : BodyGeometry{}, head);
}

/// \param exposed_at  of a valid pose: where the head stood then; null: where it stands now
void fill_head(const HeadSnapshot& head, const MonoTime* exposed_at, Report& report) noexcept {
  const HeadAngles angles = exposed_at != nullptr ? head.track.at(*exposed_at) : head.track.newest();
  report.head = {true,           angles.pan_rad, angles.tilt_rad, head.limited, head.failed,
                 head.inhibited, head.order,     head.progress,   head.state};
}

static_assert(kMostReportSights == kMaxLandmarksInView);

void fill_sights(const Fix& fix, MonoTime exposed_at, Report& report) noexcept {
  report.sights.clear();
  for (const LandmarkFix& landmark : fix.landmarks) {
    if (!landmark.place_is_sure) continue;
    const Eigen::Vector3d p_m = landmark.pose().T_landmark_camera.inverse().translation_m;
    (void)report.sights.try_push_back({landmark.id, exposed_at, {p_m.x(), p_m.y(), p_m.z()}});
  }
}

void mark_invalid(Reason reason, Report& report) noexcept {
  report.valid = report.found = report.tracking = report.ambiguous = false;
  report.rival = {};
  report.sights.clear();
  report.quality = 0;
  report.landmarks_seen = report.landmarks_rejected = 0;
  report.reason = reason;
}

}  // namespace

Report next_report(const Report& before, const Frame& frame, const Fix& fix, const ReportContext& context) noexcept {
  Report report = before;
  ++(fix.reason == Reason::kFrameSize ? report.frames.failed : report.frames.processed);
  report.frames.dropped += context.dropped_before;
  report.frames.work = fix.work;
  report.frame_number = frame.number;
  report.calibrated = fix.calibrated;
  report.solver = fix.solver;
  const MonoTime exposed_at = frame.exposed_at();
  if (fix.reason == Reason::kNone) {
    fill_pose(fix.main(), mounted_at(frame, context), report);
    report.has_pose = true;
    report.exposed_at = exposed_at;
    ++report.pose_sequence;
    report.valid = true;
    report.ambiguous = false;
    report.reason = Reason::kNone;
  } else {
    mark_invalid(fix.reason, report);
  }
  fill_sights(fix, exposed_at, report);
  if (!fix.landmarks.empty()) fill_rival(fix.main(), mounted_at(frame, context), report);
  if (fix.reason == Reason::kAmbiguous) {
    report.ambiguous = true;
    report.ambiguity = std::max(fix.main().pose().ambiguity, fix.odds_of_other_places);
  }
  report.landmarks_seen = static_cast<std::uint16_t>(fix.landmarks.size());
  report.landmarks_rejected = static_cast<std::uint16_t>(fix.rejected.size());
  if (report.landmarks_rejected > 0) report.last_rejected_id = fix.rejected[report.landmarks_rejected - 1U];
  report.landmarks_disputed = static_cast<std::uint16_t>(fix.disputed.size());
  for (std::size_t i = 0; i < report.disputed_ids.size(); ++i)
    report.disputed_ids[i] = i < fix.disputed.size() ? fix.disputed[i] : Report{}.disputed_ids[i];
  report.found = fix.found;
  report.tracking = fix.tracked;
  report.process_time = fix.process_time;
  report.row_time = fix.row_time;
  if (context.head != nullptr) {
    fill_head(*context.head, report.valid ? &exposed_at : nullptr, report);
  } else {
    const HeadAngles recorded = frame.head.value_or(HeadAngles{});
    report.head.pan_rad = recorded.pan_rad;
    report.head.tilt_rad = recorded.tilt_rad;
  }
  report.published_at = context.now;
  if (fix.reason != Reason::kFrameSize) report.latency = context.now - exposed_at;
  return report;
}

Report with_pose_of(const Report& report, const Frame& frame, const LandmarkFix& landmark,
                    const ReportContext& context) noexcept {
  const CameraOnBody camera = mounted_at(frame, context);
  Report shown = report;
  fill_pose(landmark, camera, shown);
  fill_rival(landmark, camera, shown);
  shown.valid = landmark.verdict == Reason::kNone;
  shown.reason = landmark.verdict;
  shown.has_pose = true;
  shown.exposed_at = frame.exposed_at();
  return shown;
}

Report report_of_failure(const Report& before, Reason reason, const ReportContext& context) noexcept {
  EXPECTS(reason != Reason::kNone);
  Report report = before;
  mark_invalid(reason, report);
  if (reason == Reason::kFrameSize || reason == Reason::kFrameUnreadable) ++report.frames.failed;
  if (context.head != nullptr) fill_head(*context.head, nullptr, report);
  report.published_at = context.now;
  return report;
}

Report report_of_head(const Report& before, const ReportContext& context) noexcept {
  EXPECTS(!before.valid);
  Report report = before;
  if (context.head != nullptr) fill_head(*context.head, nullptr, report);
  report.published_at = context.now;
  return report;
}

}  // namespace ninedot
