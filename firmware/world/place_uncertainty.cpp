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

}  // namespace ninedot
