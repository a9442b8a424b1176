#include "pose/pose_of_outlines.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "pose/ellipse_parameters.h"

namespace ninedot {
namespace {

// Of all outlines alike, beyond noise: what rendered sRGB pictures without noise leave, and tone curves' residue.
constexpr double kCommonShift_px = 0.002;
constexpr double kHalf = 0.5;  // of its outline: a dot that shows less counts as hidden in the founding paper's levels
constexpr double kMaxMisfit = 0.3;  // of a dot's radius: what is further off is no print of the landmark
constexpr double kMaxSigma = 0.1;   // of the distance: whoever knows no more has no position
constexpr int kLeastDots = 3;       // three discs determine a plane's pose, two leave a turn about their line

/// From (rotation about the landmark's origin, translation) of the sheet before the camera to (position of the camera
/// in S0, rotation vector in the camera frame): dc = R_lc (dw x t - dt), w = -dw.
Matrix6d covariance_of(const OutlineRefiner& refiner, const Eigen::Matrix3d& R_landmark_camera,
                       const CameraModel& camera) noexcept {
  const Eigen::Vector3d& t = refiner.state().T_camera_landmark.translation_m;
  Eigen::Matrix3d t_cross;
  t_cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix6d M = Matrix6d::Zero();
  M.topLeftCorner<3, 3>() = -R_landmark_camera * t_cross / kLever_m;
  M.topRightCorner<3, 3>() = -R_landmark_camera;
  M.bottomLeftCorner<3, 3>() = -Eigen::Matrix3d::Identity() / kLever_m;
  const UnknownMatrix all = refiner.information().inverse();
  Matrix6d covariance = M * all.topLeftCorner<6, 6>() * M.transpose();
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  covariance.bottomRightCorner<3, 3>().diagonal().array() += std::pow(kCommonShift_px / camera.fx_px, 2);
  return covariance;
}

/// 0 nothing hidden, I..III of the founding paper as 1..3.
int occlusion_level(const std::array<double, kDotCount>& visible) noexcept {
  if (visible[kCentreDot] < kHalf) return 3;
  const auto hidden =
      std::count_if(visible.begin(), visible.begin() + kRingDotCount, [](double v) { return v < kHalf; });
  return hidden > 2 ? 2 : hidden > 0 ? 1 : 0;
}

}  // namespace

PoseCandidate candidate_of(const OutlineRefiner& refiner, const CameraModel& camera,
                           const LandmarkGeometry& landmark) noexcept {
  PoseCandidate candidate;
  candidate.outlines = refiner.state();
  candidate.statistics = refiner.statistics();
  candidate.visible_share = refiner.visible_share();
  candidate.light_smooth = refiner.is_light_smooth();
  PoseEstimate& pose = candidate.pose;
  pose.T_landmark_camera = refiner.state().T_camera_landmark.inverse();
  pose.rms_px = refiner.rms_px();
  pose.ellipse = ellipse_parameters(pose.T_landmark_camera, camera, landmark);
  pose.covariance = covariance_of(refiner, pose.T_landmark_camera.rotation, camera);
  const auto& visible = candidate.visible_share;
  pose.dots_used = static_cast<int>(std::ranges::count_if(visible, [](double share) { return share >= kMinVisible; }));
  pose.occlusion_level = occlusion_level(visible);
  return candidate;
}

Result<void> check_pose(const PoseEstimate& pose, const CameraModel& camera,
                        const LandmarkGeometry& landmark) noexcept {
  const double distance_m = pose.T_landmark_camera.translation_m.norm();
  if (pose.rms_px > kMaxMisfit * camera.fx_px * landmark.dot_radius_m / distance_m)
    return fail(Errc::kNoLandmark, "the outlines do not lie where those of one landmark would");
  const double sigma_m = std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace());
  if (!(sigma_m < kMaxSigma * distance_m) || pose.dots_used < kLeastDots)
    return fail(Errc::kPoseDegenerate, "the visible outlines do not determine a pose");
  return {};
}

}  // namespace ninedot
