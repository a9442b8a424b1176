#include "pipeline/picture_row_time.h"

#include <algorithm>
#include <cmath>

#include "pipeline/camera_twist.h"
#include "world/scene.h"

namespace ninedot {
namespace {

/// 1-sigma of a sheet's speed as its own track foretells it, where a hand shakes the camera; measured, it is better.
/// [1]
constexpr double kForecastShare = 0.3;
/// From the place that one landmark gives to that of all: a degree or two.
constexpr int kRounds = 3;
/// Landmarks that give a place to begin with; one of three is no mirror image.
constexpr std::size_t kStarts = 3;

WorldFromCamera camera_by(const WorldFromLandmark& T_world_landmark, const CameraFromLandmark& T) noexcept {
  return T_world_landmark * T.inverse();
}

}  // namespace

void PictureRowTime::add(const LandmarkSighting& sighting, const SheetMotion& taken_by,
                         const WorldFromLandmark& T_world_landmark, const PoseCovariance* place_covariance,
                         bool is_used) noexcept {
  if (members_.full()) return;
  Member member{sighting, taken_by, taken_by, T_world_landmark, place_covariance, is_used, 0, 0, 0};
  widen_by_scatter(member.sighting, landmark_);
  const Eigen::Vector3d t_m = sighting.T_camera_landmark.translation_m;
  const auto own = sighting.T_camera_landmark.inverse();
  member.alone_chi2 = fit_of_sighting(member.sighting, {}, {own.rotation, own.translation_m}, landmark_).chi2;
  member.moved_1_s2 = taken_by.ray_velocity(t_m, t_m).squaredNorm();
  member.unsure_1_s2 = kForecastShare * kForecastShare * member.moved_1_s2;
  if (tracked_ != nullptr) {
    // A ray moves with the camera's velocity and turning rate as it does with steps of its place.
    const Eigen::Matrix<double, 2, 6> by_rates = ray_by_step(t_m, tracked_->motion.T_world_camera.rotation);
    const double unsure_1_s2 =
        (by_rates * tracked_->covariance.bottomRightCorner<6, 6>() * by_rates.transpose()).trace();
    if (member.moved_1_s2 == 0 || unsure_1_s2 < member.unsure_1_s2) {
      member.motion = twist_of(*tracked_).of_sheet_at(t_m);
      member.moved_1_s2 = member.motion.ray_velocity(t_m, t_m).squaredNorm();
      member.unsure_1_s2 = unsure_1_s2;
    }
  }
  static_cast<void>(members_.try_push_back(member));
}

std::optional<RowTimeEvidence> PictureRowTime::evidence_at(const WorldFromCamera& T_world_camera,
                                                           bool of_all) const noexcept {
  RowTimeEquations sum;
  int count = 0;
  double moved_1_s2 = 0, unsure_1_s2 = 0, rows_px = 0, rows_px2 = 0;
  for (const Member& member : members_) {
    if (!of_all && !member.is_used) continue;
    sum += equations_of_member({&member.sighting, member.T_world_landmark, member.place_covariance}, member.taken_by,
                               member.motion, T_world_camera, landmark_, camera_);
    ++count;
    moved_1_s2 += member.moved_1_s2, unsure_1_s2 += member.unsure_1_s2;
    const Eigen::Vector2d ray = member.sighting.T_camera_landmark.translation_m.hnormalized();
    const double row_px = camera_.pixel_from_normalised(ray).y();
    rows_px += row_px, rows_px2 += row_px * row_px;
  }
  if (!(moved_1_s2 > 0)) return std::nullopt;
  auto evidence = evidence_of(sum);
  if (!evidence) return std::nullopt;
  evidence->motion_share = std::sqrt(unsure_1_s2 / moved_1_s2);
  // A sheet is sheared by its speed in pixels, several are shifted by their distance in rows.
  const WorldOptions world;
  const double apart_px = std::sqrt(std::max(0.0, rows_px2 - rows_px * rows_px / count));
  evidence->unexplained_s = 1 / (std::sqrt(moved_1_s2 / count) * std::hypot(camera_.fy_px / world.unexplained_tilt_rad,
                                                                            apart_px / world.unexplained_share));
  return evidence;
}

/// Whether it agrees with each of them as well as one that hangs where the map says: by itself, for one that was moved
/// must not hide among those that were not.
bool PictureRowTime::explains_each(const WorldFromCamera& T_world_camera,
                                   const RowTimeEvidence& evidence) const noexcept {
  Eigen::Matrix<double, 7, 1> to_best;
  to_best << evidence.step, evidence.error_s;
  return std::ranges::all_of(members_, [&](const Member& member) {
    const RowTimeEquations own =
        equations_of_member({&member.sighting, member.T_world_landmark, member.place_covariance}, member.taken_by,
                            member.motion, T_world_camera, landmark_, camera_);
    const double chi2 = own.chi2 + to_best.dot(2 * own.gradient + own.normal * to_best);
    return chi2 - member.alone_chi2 < WorldOptions{}.max_disagreement_chi2;
  });
}

/// Gauss and Newton's. \pre one at least was left out
std::optional<RowTimeEvidence> PictureRowTime::evidence_that_explains_all(const WorldFromCamera& start) const noexcept {
  WorldFromCamera T = start;
  for (int round = 0; round < kRounds; ++round) {
    auto evidence = evidence_at(T, true);
    if (!evidence) return std::nullopt;
    if (explains_each(T, *evidence)) {
      evidence->is_of_left_out = true;
      return evidence;
    }
    T = moved_by(T, evidence->step);
  }
  return std::nullopt;
}

std::optional<RowTimeEvidence> PictureRowTime::evidence(
    const std::optional<WorldFromCamera>& T_world_camera) const noexcept {
  const bool are_all_used = std::ranges::all_of(members_, [](const Member& member) { return member.is_used; });
  if (T_world_camera && are_all_used) return evidence_at(*T_world_camera, true);
  for (std::size_t i = 0; members_.size() > 1 && i < std::min(members_.size(), kStarts); ++i)
    if (const auto evidence =
            evidence_that_explains_all(camera_by(members_[i].T_world_landmark, members_[i].sighting.T_camera_landmark)))
      return evidence;
  return T_world_camera ? evidence_at(*T_world_camera, false) : std::nullopt;
}

PoseInformation row_time_share(const LandmarkSighting& sighting, const SheetMotion& taken_by, double sigma_s,
                               const LandmarkGeometry& landmark, const CameraModel& camera) noexcept {
  if (sigma_s == 0) return PoseInformation::Zero();
  const auto T_landmark_camera = sighting.T_camera_landmark.inverse();
  const auto evidence =
      evidence_of(equations_of_member({&sighting, {}, nullptr}, taken_by, taken_by,
                                      {T_landmark_camera.rotation, T_landmark_camera.translation_m}, landmark, camera));
  if (!evidence) return PoseInformation::Zero();
  const PoseStep step = sigma_s * evidence->step_by_row_time;
  return step * step.transpose();
}

}  // namespace ninedot
