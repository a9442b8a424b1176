#include "pose/mirror_image.h"

#include <algorithm>
#include <cmath>

#include "base/inline_vector.h"
#include "geometry/planar_pose.h"
#include "pose/pose_of_outlines.h"

namespace ninedot {
namespace {

// Of the reflection's angle: what has come nearer has gone to the pose that it was to be the mirror image of.
constexpr double kFellBack = 0.5;
// Four places determine a plane's map exactly and may lie three on a line: as few have no second pose that is sure.
constexpr int kLeastPoints = 5;

Eigen::Vector2d ray_of_dot(const CameraFromLandmark& T, const LandmarkGeometry& landmark, std::size_t dot) noexcept {
  const Eigen::Vector2d C = landmark.centre_m(dot);
  return (T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized();
}

}  // namespace

CameraFromLandmark reflected(const CameraFromLandmark& T) noexcept {
  const Eigen::Vector3d sight = T.translation_m.normalized();
  CameraFromLandmark other = T;
  other.rotation -= 2 * sight * (sight.transpose() * T.rotation);
  other.rotation.col(1) *= -1;  // the normal: seen from in front all the same
  return other;
}

double evidence_of_places(const CameraFromLandmark& a, const CameraFromLandmark& b, const DotSightings& dots,
                          double pattern, const LandmarkGeometry& landmark) noexcept {
  double apart_chi2 = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d d = ray_of_dot(a, landmark, dot) - ray_of_dot(b, landmark, dot);
    const Eigen::Matrix2d& information = dots[dot].information;
    const Eigen::Matrix2d held = Eigen::Matrix2d::Identity() + pattern * pattern * information;
    apart_chi2 += d.dot(held.inverse() * information * d);
  }
  return apart_chi2 + 2 * std::sqrt(apart_chi2);
}

double preference_of_places(const CameraFromLandmark& a, const CameraFromLandmark& b, const DotSightings& dots,
                            const LandmarkGeometry& landmark) noexcept {
  double chi2 = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d from_a = ray_of_dot(a, landmark, dot) - dots[dot].ray,
                          from_b = ray_of_dot(b, landmark, dot) - dots[dot].ray;
    chi2 += from_b.dot(dots[dot].information * from_b) - from_a.dot(dots[dot].information * from_a);
  }
  return chi2;
}

double angle_between_rad(const CameraFromLandmark& a, const CameraFromLandmark& b) noexcept {
  return log_so3(a.rotation.transpose() * b.rotation).norm();
}

CameraFromLandmark mirror_image(const CameraFromLandmark& T, const LandmarkGeometry& landmark,
                                const std::array<double, kDotCount>& visible_share) noexcept {
  const bool are_enough = dots_in_sight(visible_share) >= kLeastPoints;
  InlineVector<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (are_enough && visible_share[dot] < kMinVisible) continue;
    (void)points.try_push_back({landmark.centre_m(dot), ray_of_dot(T, landmark, dot)});  // as many as dots
  }
  // Where the reflection climbs to is what the other one of both solutions is, at a third of the cost. Of some of the
  // dots that is not where it climbs to: they are not reflected about their own middle.
  const CameraFromLandmark reflection = reflected(T);
  const double least_rad = kFellBack * angle_between_rad(reflection, T);
  const PlanarPose climbed = refine_planar_pose(points.span(), reflection);
  if (std::isfinite(climbed.rms) && angle_between_rad(climbed.T_camera_landmark, T) >= least_rad)
    return climbed.T_camera_landmark;
  if (points.size() == kDotCount) return reflection;
  const auto poses = solve_planar_pose(points.span());
  if (!poses) return reflection;
  const CameraFromLandmark &a = (*poses)[0].T_camera_landmark, &b = (*poses)[1].T_camera_landmark;
  const double a_rad = angle_between_rad(a, T), b_rad = angle_between_rad(b, T);
  if (std::max(a_rad, b_rad) < least_rad) return reflection;
  return a_rad > b_rad ? a : b;
}

}  // namespace ninedot
