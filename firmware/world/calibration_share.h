#pragma once
/// What a calibration's own uncertainty makes of a camera's place: an error of the intrinsics is the same in all dots,
/// in all landmarks and in all frames, and nothing averages it away.
///
/// The place p is where sum A^T W (ray(p) - seen(k)) = 0 over all dots, A = d ray / d p and B = d seen / d k by the
/// intrinsics k (camera_gradients.h). So an error of k moves it by (sum A^T W A)^-1 (sum A^T W B), to first order.
#include <optional>

#include "geometry/camera_gradients.h"
#include "world/joint_fit.h"

namespace ninedot {

/// The two sums, which add up over sightings.
struct IntrinsicsPull {
  PoseInformation normal = PoseInformation::Zero();  ///< [1/m^2, 1/(m rad), 1/rad^2]
  /// Per unit of each intrinsic [1/m, 1/rad, each per px or per 1].
  Eigen::Matrix<double, 6, kIntrinsics> by_intrinsics = Eigen::Matrix<double, 6, kIntrinsics>::Zero();

  IntrinsicsPull& operator+=(const IntrinsicsPull& other) noexcept;
};

/// Of one member, the uncertainty of its landmark's place eliminated as in fit_of_member.
/// \return  zero: a dot that is seen would lie behind the camera, or none is seen
/// Memory: none. Threads: pure.
IntrinsicsPull pull_of_member(const JointMember& member, const WorldFromCamera& T_world_camera,
                              const LandmarkGeometry& landmark, const CameraModel& camera) noexcept;

/// Of the camera's place: T covariance T^T with the T of above.
/// \param intrinsics  of the calibration [px^2, px, 1]
/// \return  of a PoseStep [m^2, m rad, rad^2]; none: the dots do not determine a place
/// Memory: none. Threads: pure.
std::optional<PoseInformation> calibration_share(const IntrinsicsPull& pull,
                                                 const IntrinsicCovariance& intrinsics) noexcept;

}  // namespace ninedot
