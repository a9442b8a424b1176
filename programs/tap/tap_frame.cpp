#include "programs/tap/tap_frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "base/units.h"

namespace ninedot {
namespace {

constexpr double kMmPerM = 1000;

std::array<double, 3> in_mm(const Eigen::Vector3d& point_m) noexcept {
  return {point_m.x() * kMmPerM, point_m.y() * kMmPerM, point_m.z() * kMmPerM};
}

std::array<double, 4> wxyz(const Eigen::Quaterniond& q) noexcept { return {q.w(), q.x(), q.y(), q.z()}; }

/// \param variance  of component 0..5 [m^2, rad^2]
template <typename Variance>
void fill_sigmas(Variance variance, TapPose& to) noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    to.sigma_mm[i] = std::sqrt(variance(i)) * kMmPerM;
    to.sigma_deg[i] = std::sqrt(variance(i + 3)) * kDegPerRad;
  }
}

void fill_pose(const ReportPose& pose, const std::array<double, 36>& covariance, TapPose& to) noexcept {
  for (std::size_t i = 0; i < 3; ++i) to.position_mm[i] = pose.position_m[i] * kMmPerM;
  to.quaternion_wxyz = pose.quaternion_wxyz;
  fill_sigmas([&](std::size_t i) { return covariance[7 * i]; }, to);
}

void fill_track(const TrackedPose& track, TapFrame& tap) noexcept {
  const auto& T = track.motion.T_world_camera;
  tap.track.position_mm = in_mm(T.translation_m);
  tap.track.quaternion_wxyz = wxyz(T.quaternion());
  fill_sigmas([&](std::size_t i) { return track.covariance(static_cast<int>(i), static_cast<int>(i)); }, tap.track);
  tap.track_velocity_mm_s = in_mm(track.motion.velocity_m_s);
  tap.track_ambiguity = track.ambiguity;
}

void fill_dots(const std::array<DotObservation, kDotCount>& seen, std::array<TapDot, kTapDotCount>& to) noexcept {
  for (std::size_t dot = 0; dot < kTapDotCount; ++dot) {
    const DotObservation& from = seen[dot];
    // 0 says "not seen": whatever sliver of it there was is none to rest on.
    to[dot] = {from.centroid_px.x(),        from.centroid_px.y(),
               from.semi_major_px,          from.semi_minor_px,
               from.angle_rad * kDegPerRad, from.seen ? std::max(1e-3, static_cast<double>(from.visible_fraction)) : 0};
  }
}

TapSpot tap_spot(const Blob& from) noexcept {
  DotObservation outline;
  set_outline(from.moments_px2(), outline);
  return {from.x_px, from.y_px, static_cast<float>(outline.semi_major_px), static_cast<float>(outline.semi_minor_px),
          static_cast<float>(outline.angle_rad * kDegPerRad)};
}

TapLandmark tap_landmark(const LandmarkFix& fix) noexcept {
  TapLandmark to;
  to.id = fix.id;
  to.reason = static_cast<std::uint32_t>(fix.verdict);
  to.quality = fix.quality;
  to.dots_used = static_cast<std::uint32_t>(fix.pose().dots_used);
  to.chosen = static_cast<std::uint32_t>(fix.chosen);
  to.rival_odds = fix.candidates.rival ? fix.candidates.rival->odds : 0;
  for (const PoseCandidate& candidate : fix.candidates.list) {
    if (to.candidate_count == kTapCandidateCount) break;
    const auto& T = candidate.pose.T_landmark_camera;
    to.candidates[to.candidate_count++] = {in_mm(T.translation_m), wxyz(T.quaternion()), candidate.chi2_above,
                                           candidate.pose.rms_px};
  }
  return to;
}

void fill_head(const ReportHead& head, TapFrame& tap) noexcept {
  tap.head_pan_deg = head.pan_rad * kDegPerRad;
  tap.head_tilt_deg = head.tilt_rad * kDegPerRad;
  tap.order = head.order;
  tap.order_progress = static_cast<std::uint32_t>(head.progress);
}

void fill_counts(const Report& report, TapFrame& tap) noexcept {
  tap.frames_processed = report.frames.processed;
  tap.frames_dropped = report.frames.dropped;
  tap.frames_failed = report.frames.failed;
  tap.pose_sequence = report.pose_sequence;
  const WorkCounts& work = report.frames.work;
  tap.runs_cut = work.runs_cut;
  tap.blobs_cut = work.blobs_cut;
  tap.neighbours_cut = work.neighbours_cut;
  tap.hypotheses_cut = work.hypotheses_cut;
  tap.frames_cut = work.frames_cut;
  tap.landmarks_seen = report.landmarks_seen;
  tap.landmarks_rejected = report.landmarks_rejected;
  tap.last_rejected_id = report.last_rejected_id;
}

void fill_verdict(const Report& report, TapFrame& tap) noexcept {
  tap.reason = static_cast<std::uint32_t>(report.reason);
  tap.landmark_id = report.landmark_id;
  tap.quality = report.quality;
  tap.dots_used = report.dots_used;
  tap.occlusion_level = report.occlusion_level;
  tap.rms_px = report.rms_px;
  tap.ambiguity = report.ambiguity;
  tap.rival_odds = report.rival.odds;
  tap.distance_mm = report.distance_m * kMmPerM;
  tap.swing_deg = report.swing_psi_rad * kDegPerRad;
  tap.tilt_deg = report.tilt_phi_rad * kDegPerRad;
  tap.pan_deg = report.pan_theta_rad * kDegPerRad;
  tap.deviation_deg = report.deviation_rad * kDegPerRad;
}

std::uint32_t flags_of(const Fix& fix, const LandmarkObservation* seen, const Report& report) noexcept {
  using namespace tap_flag;
  std::uint32_t flags = 0;
  for (const auto& [is_set, flag] : {std::pair{report.valid, kValid},
                                     {report.found, kFound},
                                     {report.ambiguous, kAmbiguous},
                                     {report.has_pose, kHasPose},
                                     {report.calibrated, kCalibrated},
                                     {report.tracking, kTracking},
                                     {report.solver == Solver::kEllipse, kEllipseSolver},
                                     {fix.world.has_value(), kInWorld},
                                     {fix.track.has_value(), kHasTrack},
                                     {seen != nullptr && seen->from_pose, kDotsFromPose},
                                     {report.head.present, kHasHead},
                                     {report.head.limited, kHeadLimit},
                                     {report.head.failed, kHeadFault},
                                     {report.head.inhibited, kHeadInhibited}})
    if (is_set) flags |= flag;
  return flags;
}

DotObservation dot_of(const TapDot& from) noexcept {
  return {from.visible_fraction > 0, static_cast<float>(from.visible_fraction),
          {from.u_px, from.v_px},    from.semi_major_px,
          from.semi_minor_px,        from.angle_deg * kRadPerDeg};
}

Blob blob_of(const TapSpot& from) noexcept {
  const float angle_rad = from.angle_deg * static_cast<float>(kRadPerDeg);
  const float cosine = std::cos(angle_rad), sine = std::sin(angle_rad);
  const float along = from.semi_major_px * from.semi_major_px / 4, across = from.semi_minor_px * from.semi_minor_px / 4;
  return {.x_px = from.u_px,
          .y_px = from.v_px,
          .area_px2 = std::numbers::pi_v<float> * from.semi_major_px * from.semi_minor_px,
          .xx_px2 = along * cosine * cosine + across * sine * sine,
          .xy_px2 = (along - across) * cosine * sine,
          .yy_px2 = along * sine * sine + across * cosine * cosine,
          .level = 0};
}

}  // namespace

void describe_frame(const Frame& frame, const Fix& fix, const LandmarkObservation* seen, const Report& report,
                    TapFrame& tap) noexcept {
  tap.number = frame.number;
  tap.exposed_at_ns = to_ns(frame.exposed_at());
  tap.exposure_ns = (frame.exposure_end - frame.exposure_begin).count();
  tap.published_at_ns = to_ns(report.published_at);
  tap.pose_exposed_at_ns = report.has_pose ? to_ns(report.exposed_at) : 0;
  tap.latency_ns = report.latency.count();
  tap.process_ns = report.process_time.count();
  tap.row_time_ns = frame.row_time.count();
  tap.gain = frame.gain;
  tap.flags = flags_of(fix, seen, report);
  fill_verdict(report, tap);
  fill_counts(report, tap);
  fill_head(report.head, tap);
  fill_pose(report.camera_in_landmark, report.covariance, tap.camera_in_landmark);
  fill_pose(report.camera_in_world, report.covariance_world, tap.camera_in_world);
  fill_pose(report.body_in_world, report.covariance_body, tap.body_in_world);
  tap.track = {};
  if (fix.track) fill_track(*fix.track, tap);
  tap.dots = {};
  if (seen != nullptr) fill_dots(seen->dots, tap.dots);
  tap.landmark_count = 0;
  for (const LandmarkFix& landmark : fix.landmarks) {
    if (tap.landmark_count == kTapLandmarkCount) break;
    tap.landmarks[tap.landmark_count++] = tap_landmark(landmark);
  }
}

void describe_search(const std::optional<FailedSearch>& failed, TapFrame& tap) noexcept {
  TapSearch& to = tap.search;
  to.has_failed = failed ? 1 : 0;
  if (!failed) return;
  to.refusal = static_cast<std::uint32_t>(failed->refusal);
  to.contrast_lsb = failed->contrast_lsb;
  to.noise_lsb = failed->noise_lsb;
  fill_dots(failed->dots, to.dots);
  to.spots_seen = static_cast<std::uint32_t>(failed->spots.size());
  to.spot_count = 0;
  for (const Blob& spot : failed->spots) {
    if (to.spot_count == kTapSpotCount) break;
    to.spots[to.spot_count++] = tap_spot(spot);
  }
}

Report report_of(const TapFrame& tap) noexcept {
  Report report;
  report.frame_number = tap.number;
  report.latency = std::chrono::nanoseconds(tap.latency_ns);
  report.process_time = std::chrono::nanoseconds(tap.process_ns);
  report.valid = (tap.flags & tap_flag::kValid) != 0;
  report.found = (tap.flags & tap_flag::kFound) != 0;
  report.ambiguous = (tap.flags & tap_flag::kAmbiguous) != 0;
  report.has_pose = (tap.flags & tap_flag::kHasPose) != 0;
  report.calibrated = (tap.flags & tap_flag::kCalibrated) != 0;
  report.tracking = (tap.flags & tap_flag::kTracking) != 0;
  report.solver = (tap.flags & tap_flag::kEllipseSolver) != 0 ? Solver::kEllipse : Solver::kFull;
  report.reason = tap.reason < kReasons.size() ? static_cast<Reason>(tap.reason) : Reason::kNoLandmark;
  report.landmark_id = static_cast<std::uint16_t>(tap.landmark_id);
  report.dots_used = static_cast<std::uint16_t>(tap.dots_used);
  report.occlusion_level = static_cast<std::uint16_t>(tap.occlusion_level);
  report.rms_px = tap.rms_px;
  report.ambiguity = tap.ambiguity;
  report.distance_m = tap.distance_mm / kMmPerM;
  report.tilt_phi_rad = tap.tilt_deg * kRadPerDeg;
  for (std::size_t i = 0; i < 3; ++i) {
    const TapPose& pose = tap.camera_in_landmark;
    report.camera_in_landmark.position_m[i] = pose.position_mm[i] / kMmPerM;
    report.covariance[7 * i] = std::pow(pose.sigma_mm[i] / kMmPerM, 2);
    report.covariance[7 * (i + 3)] = std::pow(pose.sigma_deg[i] * kRadPerDeg, 2);
  }
  report.camera_in_landmark.quaternion_wxyz = tap.camera_in_landmark.quaternion_wxyz;
  return report;
}

bool observation_of(const TapFrame& tap, LandmarkObservation& seen) noexcept {
  seen = {};
  seen.from_pose = (tap.flags & tap_flag::kDotsFromPose) != 0;
  for (std::size_t dot = 0; dot < kTapDotCount; ++dot) {
    const TapDot& from = tap.dots[dot];
    if (!(from.visible_fraction > 0)) continue;
    seen.dots[dot] = dot_of(from);
    ++seen.seen_count;
  }
  return seen.seen_count > 0;
}

std::optional<FailedSearch> search_of(const TapFrame& tap, BlobList& spots) noexcept {
  const TapSearch& from = tap.search;
  if (from.has_failed == 0) return std::nullopt;
  FailedSearch failed;
  failed.refusal = from.refusal < kRefusalSentences.size() ? static_cast<Refusal>(from.refusal) : Refusal::kNone;
  failed.contrast_lsb = from.contrast_lsb;
  failed.noise_lsb = from.noise_lsb;
  std::ranges::transform(from.dots, failed.dots.begin(), dot_of);
  spots.clear();
  for (const TapSpot& spot : std::span(from.spots).first(std::min<std::size_t>(from.spot_count, kTapSpotCount)))
    (void)spots.try_push_back(blob_of(spot));  // a BlobList has room for more
  failed.spots = spots.span();
  return failed;
}

void describe_camera(const CameraModel& camera, const LandmarkGeometry& landmark, TapHeader& header) noexcept {
  header.width_px = static_cast<std::uint32_t>(camera.width_px);
  header.height_px = static_cast<std::uint32_t>(camera.height_px);
  header.lens_model = static_cast<std::uint32_t>(camera.model);
  header.intrinsics_px = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
  header.distortion = camera.k;
  header.ring_radius_mm = landmark.ring_radius_m * kMmPerM;
  header.dot_radius_mm = landmark.dot_radius_m * kMmPerM;
  header.centre_radius_mm = landmark.centre_radius_m * kMmPerM;
}

CameraModel camera_of(const TapHeader& header) noexcept {
  CameraModel camera;
  camera.width_px = static_cast<int>(header.width_px);
  camera.height_px = static_cast<int>(header.height_px);
  camera.model = static_cast<DistortionModel>(header.lens_model);
  camera.fx_px = header.intrinsics_px[0], camera.fy_px = header.intrinsics_px[1];
  camera.cx_px = header.intrinsics_px[2], camera.cy_px = header.intrinsics_px[3];
  camera.k = header.distortion;
  return camera;
}

LandmarkGeometry landmark_of(const TapHeader& header) noexcept {
  return {header.ring_radius_mm / kMmPerM, header.dot_radius_mm / kMmPerM, header.centre_radius_mm / kMmPerM};
}

}  // namespace ninedot
