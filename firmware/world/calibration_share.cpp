#include "world/calibration_share.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

// Products of these sizes are written out: Eigen's kernels for large ones spend more on packing than on multiplying.
namespace ninedot {
namespace {

/// Position in the landmark's axes, rotation in the camera's. [1/m^2 .. 1/rad^2]
IntrinsicsPull pull_of_dots(const DotSightings& dots, const CameraFromLandmark& T_camera_landmark,
                            const LandmarkGeometry& landmark, const CameraModel& camera) noexcept {
  IntrinsicsPull pull;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Matrix2d& W = dots[dot].information;
    if (W(0, 0) == 0 && W(1, 1) == 0) continue;
    const Eigen::Vector2d on_sheet_m = landmark.centre_m(dot);
    const Eigen::Vector3d p_m = T_camera_landmark * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
    if (!(p_m.z() > kNearestSeen_m)) return {};
    // Position in the landmark's axes: the camera's rotation in them is that of the inverse.
    const Eigen::Matrix<double, 2, 6> A = ray_by_step(p_m, T_camera_landmark.rotation.transpose());
    const Eigen::Matrix<double, 6, 2> AW = A.transpose().lazyProduct(W);
    pull.normal += AW.lazyProduct(A);
    pull.by_intrinsics += AW.lazyProduct(ray_by_intrinsics(camera, p_m.hnormalized()));
  }
  return pull;
}

}  // namespace

IntrinsicsPull& IntrinsicsPull::operator+=(const IntrinsicsPull& other) noexcept {
  normal += other.normal;
  by_intrinsics += other.by_intrinsics;
  return *this;
}

IntrinsicsPull pull_of_member(const JointMember& member, const WorldFromCamera& T_world_camera,
                              const LandmarkGeometry& landmark, const CameraModel& camera) noexcept {
  IntrinsicsPull pull =
      pull_of_dots(member.sighting->dots, T_world_camera.inverse() * member.T_world_landmark, landmark, camera);
  const Eigen::Matrix3d& R = member.T_world_landmark.rotation;
  pull.normal.topRows<3>() = R.lazyProduct(pull.normal.topRows<3>()).eval();
  pull.normal.leftCols<3>() = pull.normal.leftCols<3>().lazyProduct(R.transpose()).eval();
  pull.by_intrinsics.topRows<3>() = R.lazyProduct(pull.by_intrinsics.topRows<3>()).eval();
  PoseCovariance C = step_covariance_of_turn(member.sighting->turn_sigma_rad);
  if (member.place_covariance != nullptr)
    C += step_covariance_of_place(*member.place_covariance, member.T_world_landmark, T_world_camera);
  if (C.isZero(0)) return pull;
  const Eigen::PartialPivLU<PoseInformation> held(PoseInformation::Identity() + pull.normal * C);
  const PoseInformation normal = held.solve(pull.normal);
  return {(normal + normal.transpose()) / 2, held.solve(pull.by_intrinsics)};
}

std::optional<PoseInformation> calibration_share(const IntrinsicsPull& pull,
                                                 const IntrinsicCovariance& intrinsics) noexcept {
  const Eigen::LDLT<PoseInformation> solver(pull.normal);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
  const Eigen::Matrix<double, 6, kIntrinsics> by_sigma = pull.by_intrinsics.lazyProduct(intrinsics);
  const PoseInformation inverse = solver.solve(PoseInformation::Identity());
  const PoseInformation half = inverse.lazyProduct(by_sigma.lazyProduct(pull.by_intrinsics.transpose()).eval());
  const PoseInformation share = half.lazyProduct(inverse);
  if (!share.allFinite()) return std::nullopt;
  return (share + share.transpose()) / 2;
}

}  // namespace ninedot
