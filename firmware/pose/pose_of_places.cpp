#include "pose/pose_of_places.h"

#include <Eigen/Cholesky>

namespace ninedot {
namespace {

constexpr int kMostSteps = 5;
// In units of the covariance: what is left after such a step is its square, over the tilts' own bend.
constexpr double kSmallStep_chi2 = 0.01;

}  // namespace

std::optional<PoseOfPlaces> fit_to_places(const DotSightings& dots, const LandmarkGeometry& landmark,
                                          const CameraFromLandmark& start) noexcept {
  PoseOfPlaces pose{start};
  CameraFromLandmark& T = pose.T_camera_landmark;
  for (int i = 0; i < kMostSteps; ++i) {
    Matrix6d normal = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      if (!(dots[dot].information.trace() > 0)) continue;
      const Eigen::Vector2d C = landmark.centre_m(dot);
      const Eigen::Vector3d q = T.rotation * Eigen::Vector3d(C.x(), 0, C.y()), p = q + T.translation_m;
      if (!(p.z() > 0)) return std::nullopt;
      const Eigen::Vector2d ray = p.hnormalized();
      // A small turn w moves the dot by w x q.
      Eigen::Matrix<double, 2, 3> by_move;
      by_move << 1, 0, -ray.x(), 0, 1, -ray.y();
      Eigen::Matrix3d by_turn;
      by_turn << 0, q.z(), -q.y(), -q.z(), 0, q.x(), q.y(), -q.x(), 0;
      Eigen::Matrix<double, 2, 6> J;
      J << by_move * by_turn, by_move;
      J /= p.z();
      const Eigen::Matrix<double, 6, 2> weighted = J.transpose() * dots[dot].information;
      normal += weighted * J;
      gradient += weighted * (dots[dot].ray - ray);
    }
    const Eigen::LDLT<Matrix6d> ldlt(normal);
    if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return std::nullopt;
    const Vector6d step = ldlt.solve(gradient);
    T.rotation = exp_so3(step.head<3>()) * T.rotation;
    T.translation_m += step.tail<3>();
    if (i + 1 < kMostSteps && step.dot(normal * step) > kSmallStep_chi2) continue;
    pose.covariance = ldlt.solve(Matrix6d::Identity());
    break;
  }
  if (!(T.translation_m.z() > 0) || !pose.covariance.allFinite()) return std::nullopt;
  return pose;
}

}  // namespace ninedot
