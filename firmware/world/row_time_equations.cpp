#include "world/row_time_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace ninedot {
namespace {

using Matrix7 = Eigen::Matrix<double, 7, 7>;

}  // namespace

RowTimeEquations& RowTimeEquations::operator+=(const RowTimeEquations& other) noexcept {
  chi2 += other.chi2;
  normal += other.normal;
  gradient += other.gradient;
  return *this;
}

RowTimeEquations equations_of_member(const JointMember& member, const SheetMotion& taken_by, const SheetMotion& motion,
                                     const WorldFromCamera& T_world_camera, const LandmarkGeometry& landmark,
                                     const CameraModel& camera) noexcept {
  const CameraFromLandmark T = T_world_camera.inverse() * member.T_world_landmark;
  RowTimeEquations sum;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const DotSighting& seen = member.sighting->dots[dot];
    if (seen.information(0, 0) == 0 && seen.information(1, 1) == 0) continue;
    const Eigen::Vector2d on_sheet_m = landmark.centre_m(dot);
    const Eigen::Vector3d p_m = T * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
    if (!(p_m.z() > kNearestSeen_m)) return {.chi2 = std::numeric_limits<double>::infinity()};
    const double rows = camera.pixel_from_normalised(seen.ray).y() - taken_by.middle_row_px;
    const Eigen::Vector2d moved = rows * motion.ray_velocity(p_m, T.translation_m);
    const Eigen::Vector2d taken = rows * taken_by.ray_velocity(p_m, T.translation_m);
    Eigen::Matrix<double, 2, 7> A;
    A << ray_by_step(p_m, T_world_camera.rotation), moved;
    const Eigen::Matrix<double, 7, 2> AW = A.transpose().lazyProduct(seen.information);
    sum.normal += AW.lazyProduct(A);
    const Eigen::Vector2d residual = p_m.hnormalized() - seen.ray - taken_by.row_time_s * (taken - moved);
    sum.gradient += AW.lazyProduct(residual);
    sum.chi2 += residual.dot(seen.information * residual);
  }
  PoseCovariance C = step_covariance_of_turn(member.sighting->turn_sigma_rad);
  if (member.place_covariance != nullptr)
    C += step_covariance_of_place(*member.place_covariance, member.T_world_landmark, T_world_camera);
  if (C.isZero(0)) return sum;
  Matrix7 held = Matrix7::Identity();
  held.leftCols<6>() += sum.normal.leftCols<6>().lazyProduct(C);
  const Eigen::PartialPivLU<Matrix7> solver(held);
  const Matrix7 normal = solver.solve(sum.normal);
  RowTimeEquations soft{sum.chi2, (normal + normal.transpose()) / 2, solver.solve(sum.gradient)};
  soft.chi2 -= sum.gradient.head<6>().dot(C * soft.gradient.head<6>());
  return soft;
}

std::optional<RowTimeEvidence> evidence_of(const RowTimeEquations& equations) noexcept {
  const Eigen::LDLT<PoseInformation> place(equations.normal.topLeftCorner<6, 6>());
  if (place.info() != Eigen::Success || !(place.vectorD().minCoeff() > 0)) return std::nullopt;
  const PoseStep by_row_time = equations.normal.topRightCorner<6, 1>();
  RowTimeEvidence evidence;
  evidence.step_by_row_time = -place.solve(by_row_time);
  evidence.information_1_s2 = equations.normal(6, 6) + by_row_time.dot(evidence.step_by_row_time);
  const double pull_1_s = equations.gradient(6) + evidence.step_by_row_time.dot(equations.gradient.head<6>());
  if (!(evidence.information_1_s2 > 0)) evidence.information_1_s2 = 0;
  if (evidence.information_1_s2 > 0) evidence.error_s = -pull_1_s / evidence.information_1_s2;
  const PoseStep pull = equations.gradient.head<6>();
  evidence.step = evidence.error_s * evidence.step_by_row_time - place.solve(pull);
  if (!evidence.step_by_row_time.allFinite() || !std::isfinite(evidence.error_s)) return std::nullopt;
  return evidence;
}

}  // namespace ninedot
