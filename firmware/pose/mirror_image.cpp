#include "pose/mirror_image.h"

#include "base/inline_vector.h"
#include "geometry/planar_pose.h"

namespace ninedot {

double angle_between_rad(const CameraFromLandmark& a, const CameraFromLandmark& b) noexcept {
  return log_so3(a.rotation.transpose() * b.rotation).norm();
}

CameraFromLandmark mirror_image(const CameraFromLandmark& T, const LandmarkGeometry& landmark) noexcept {
  InlineVector<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = landmark.centre_m(dot);
    (void)points.try_push_back({C, (T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized()});  // as many as dots
  }
  const auto poses = solve_planar_pose(points.span());
  if (!poses) return T;
  const CameraFromLandmark &a = (*poses)[0].T_camera_landmark, &b = (*poses)[1].T_camera_landmark;
  return angle_between_rad(a, T) > angle_between_rad(b, T) ? a : b;
}

}  // namespace ninedot
