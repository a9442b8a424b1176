// The landmark is looked for where it was in the frame before, then everywhere. The chosen solver turns it into a pose,
// and a pose that is not finite or claims no uncertainty at all counts as none. A report is written only at the end,
// so that a failure on the way leaves the last pose whole.
#include "pipeline/localiser.h"

#include <algorithm>
#include <cmath>

#include "pipeline/report_reason.h"

namespace ninedot {
namespace {

// A landmark whose motion is foretold no better than this is found sooner by the detector than by its outlines.
constexpr double kLittleSurprise_px = 0.5;

ReportPose report_pose(const Eigen::Vector3d& position_m, const Eigen::Quaterniond& q) noexcept {
  return {{position_m.x(), position_m.y(), position_m.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

}  // namespace

bool is_publishable(const PoseEstimate& pose) noexcept {
  const EllipseParameters& e = pose.ellipse;
  const double sum = e.swing_psi_rad + e.tilt_phi_rad + e.pan_theta_rad + e.distance_m + e.image_distance_m +
                     e.deviation_rad + pose.ambiguity + pose.rms_px;
  return std::isfinite(sum) && pose.T_landmark_camera.rotation.allFinite() &&
         pose.T_landmark_camera.translation_m.allFinite() && pose.covariance.allFinite() &&
         (pose.covariance.diagonal().array() > 0).all();
}

std::uint16_t pose_quality(const PoseEstimate& pose) noexcept {
  constexpr double kHalfPrecision = 0.005;  // 0.5 % of the distance: what an integrator would still drive on
  const double sigma_m = std::sqrt(std::max(0.0, pose.covariance.topLeftCorner<3, 3>().trace()));
  const double ratio = sigma_m / (kHalfPrecision * pose.T_landmark_camera.translation_m.norm());
  const double precision = 1 / (1 + ratio * ratio);
  const double visible = std::clamp(pose.dots_used / static_cast<double>(kDotCount), 0.0, 1.0);
  const double unique = 1 - std::clamp(pose.ambiguity, 0.0, 1.0) / 2;
  const double quality = 1000 * precision * visible * unique;
  return std::isfinite(quality) ? static_cast<std::uint16_t>(std::lround(quality)) : std::uint16_t{0};
}

std::array<double, 6> world_sigmas(const PoseEstimate& pose,
                                   const Transform<frame::World, frame::Landmark>& T_world_landmark) noexcept {
  const Eigen::Matrix3d R_world_landmark = T_world_landmark.rotation;
  const Eigen::Matrix3d R_world_camera = R_world_landmark * pose.T_landmark_camera.rotation;
  const Eigen::Matrix3d position =
      R_world_landmark * pose.covariance.topLeftCorner<3, 3>() * R_world_landmark.transpose();
  const Eigen::Matrix3d rotation =
      R_world_camera * pose.covariance.bottomRightCorner<3, 3>() * R_world_camera.transpose();
  std::array<double, 6> sigmas{};
  for (Eigen::Index i = 0; i < 3; ++i) {
    sigmas[static_cast<std::size_t>(i)] = std::sqrt(std::max(0.0, position(i, i)));
    sigmas[static_cast<std::size_t>(i) + 3] = std::sqrt(std::max(0.0, rotation(i, i)));
  }
  return sigmas;
}

Localiser::Localiser(const CameraModel& camera, const LocaliserOptions& options)
    : options_(options),
      focal_px_(camera.fx_px),
      detector_(camera, options.landmark, options.detector),
      full_(camera, options.landmark),
      ellipse_(camera, options.landmark, options.ellipse) {}

Result<PoseEstimate> Localiser::solve(const ImageView& luma, const PoseEstimate* previous) noexcept {
  Result<PoseEstimate> pose =
      options_.solver == Solver::kFull ? full_.solve(luma, seen_, previous) : ellipse_.solve(seen_);
  if (pose && !is_publishable(*pose)) return fail(Errc::kPoseDegenerate, "the pose or its covariance is not finite");
  return pose;
}

CameraFromLandmark Localiser::expected_at(MonoTime time) const noexcept {
  auto T = pose_.T_landmark_camera.inverse();
  if (!motion_) return T;
  const double ahead_s = std::chrono::duration<double>(time - pose_at_).count();
  T.rotation = exp_so3(ahead_s * motion_->rotation_rad) * T.rotation;
  T.translation_m += ahead_s * motion_->translation_m;
  return T;
}

Result<PoseEstimate> Localiser::follow(const ImageView& luma, MonoTime exposed_at) noexcept {
  if (!options_.tracking || !found_last_) return fail(Errc::kNoLandmark, "there is no track");
  if (options_.solver == Solver::kFull && solved_last_ && surprise_px_ < kLittleSurprise_px)
    if (const auto pose = full_.follow(luma, expected_at(exposed_at), pose_, seen_); pose && is_publishable(*pose))
      return pose;
  // The full solver's pose says best where the sheet is; the ellipse's is worse than what was seen.
  const bool by_pose = solved_last_ && options_.solver == Solver::kFull;
  const LandmarkForecast expected =
      by_pose ? LandmarkForecast(pose_.T_landmark_camera.inverse()) : LandmarkForecast(seen_, true);
  NINEDOT_TRY(seen_, detector_.find_landmark_near(luma, expected));
  return solve(luma, solved_last_ ? &pose_ : nullptr);
}

Result<PoseEstimate> Localiser::search(const ImageView& luma) noexcept {
  found_last_ = false;
  NINEDOT_TRY(const auto found, detector_.find_landmarks(luma));
  seen_ = found.front();
  found_last_ = true;
  return solve(luma, nullptr);
}

void Localiser::fill_pose(const PoseEstimate& pose, Report& report) const noexcept {
  const auto T_world_camera = options_.T_world_landmark * pose.T_landmark_camera;
  report.camera_in_landmark = report_pose(pose.T_landmark_camera.translation_m, pose.T_landmark_camera.quaternion());
  report.camera_in_world = report_pose(T_world_camera.translation_m, T_world_camera.quaternion());
  for (Eigen::Index row = 0; row < 6; ++row)
    for (Eigen::Index column = 0; column < 6; ++column)
      report.covariance[static_cast<std::size_t>(6 * row + column)] = pose.covariance(row, column);
  report.sigma_world = world_sigmas(pose, options_.T_world_landmark);
  report.landmark_id = options_.landmark_id;
  report.quality = pose_quality(pose);
  report.ambiguity = pose.ambiguity;
  report.ambiguous = pose.ambiguity > options_.max_ambiguity;
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

void Localiser::note_motion(const Result<PoseEstimate>& pose, MonoTime exposed_at) noexcept {
  const double since_s = std::chrono::duration<double>(exposed_at - pose_at_).count();
  if (!pose || !solved_last_ || !(since_s > 0)) {
    motion_.reset();
    surprise_px_ = 0;
    return;
  }
  const auto before = pose_.T_landmark_camera.inverse(), now = pose->T_landmark_camera.inverse();
  const auto direction = [](const Eigen::Vector3d& p_camera_m) -> Eigen::Vector2d { return p_camera_m.hnormalized(); };
  surprise_px_ = focal_px_ * (direction(expected_at(exposed_at).translation_m) - direction(now.translation_m)).norm();
  motion_ = Motion{log_so3(now.rotation * before.rotation.transpose()) / since_s,
                   (now.translation_m - before.translation_m) / since_s};
}

void Localiser::process(const ImageView& luma, MonoTime exposed_at, std::uint64_t frame_number,
                        Report& report) noexcept {
  const MonoTime begin = mono_now();
  ++report.heartbeat;
  report.frame_number = frame_number;
  report.calibrated = options_.calibrated;
  report.solver = options_.solver;

  Result<PoseEstimate> pose = follow(luma, exposed_at);
  const bool tracked = pose.has_value();
  if (!tracked) pose = search(luma);  // the landmark jumped, or what was near the track is not it
  note_motion(pose, exposed_at);
  solved_last_ = pose.has_value();
  if (pose) {
    pose_ = *pose;
    pose_at_ = exposed_at;
    fill_pose(pose_, report);
    report.exposed_at = exposed_at;
    ++report.pose_sequence;
    report.valid = true;
    report.reason = Reason::kNone;
  } else {
    mark_invalid(reason_of(pose.error().code), report);
  }
  report.found = found_last_;
  report.tracking = tracked;
  report.process_time = mono_now() - begin;
}

}  // namespace ninedot
