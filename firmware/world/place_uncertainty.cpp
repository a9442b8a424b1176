#include "world/place_uncertainty.h"

#include <Eigen/LU>

namespace ninedot {

PoseCovariance step_covariance_of_place(const PoseCovariance& place_covariance,
                                        const WorldFromLandmark& T_world_landmark,
                                        const WorldFromCamera& T_world_camera) noexcept {
  const Eigen::Vector3d arm_m = T_world_landmark.translation_m - T_world_camera.translation_m;
  Eigen::Matrix3d cross;
  cross << 0, -arm_m.z(), arm_m.y(), arm_m.z(), 0, -arm_m.x(), -arm_m.y(), arm_m.x(), 0;
  PoseCovariance B;
  B << -Eigen::Matrix3d::Identity(), -cross, Eigen::Matrix3d::Zero(), -T_world_camera.rotation.transpose();
  return B * place_covariance * B.transpose();
}

PoseCovariance step_covariance_of_turn(double turn_sigma_rad) noexcept {
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance.diagonal().tail<3>().setConstant(turn_sigma_rad * turn_sigma_rad);
  return covariance;
}

SightingFit softened(const SightingFit& fit, const PoseCovariance& step_covariance) noexcept {
  const PoseInformation held = PoseInformation::Identity() + fit.normal * step_covariance;
  const Eigen::PartialPivLU<PoseInformation> solver(held);
  SightingFit soft = fit;
  soft.gradient = solver.solve(fit.gradient);
  const PoseInformation normal = solver.solve(fit.normal);
  soft.normal = (normal + normal.transpose()) / 2;
  // g (N + C^-1)^-1 g = g C (1 + N C)^-1 g
  soft.chi2 -= fit.gradient.dot(step_covariance * soft.gradient);
  return soft;
}

SightingFit softened_by_turn(const SightingFit& fit, double turn_sigma_rad) noexcept {
  Eigen::Matrix3d turns = fit.normal.bottomRightCorner<3, 3>();
  turns.diagonal().array() += 1 / (turn_sigma_rad * turn_sigma_rad);
  const Eigen::Matrix3d inverse = turns.inverse();
  const Eigen::Matrix<double, 6, 3> by_turn = fit.normal.rightCols<3>() * inverse;
  SightingFit soft = fit;
  soft.normal -= by_turn * fit.normal.bottomRows<3>();
  soft.gradient -= by_turn * fit.gradient.tail<3>();
  soft.chi2 -= fit.gradient.tail<3>().dot(inverse * fit.gradient.tail<3>());
  return soft;
}

}  // namespace ninedot
