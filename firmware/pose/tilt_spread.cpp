#include "pose/tilt_spread.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

// A dot's residual, times its depth, is linear in the translation and the turn about the line of sight, and quadratic
// in the tilt u (exp(u) to second order). Least squares eliminates the former four; chi^2 of what is left is a quartic
// f^T M f with f = (1, u1, u2, u1^2, u1 u2, u2^2), which a grid over the tilts costs little to sum.

namespace ninedot {
namespace {

// Tilt over its sigma from which the other crest is apart: between crests that are 2 k sigma apart the quartic rises to
// k^2 / 4, which is 9 here (kUndecided_chi2).
constexpr double kApartSigmas = 6;
// The grid reaches so far beyond both crests, in so many steps from its middle: at most 1.25 sigma each, for which the
// trapezoid rule is exact to 2e-4 of a Gaussian.
constexpr double kReachSigmas = 4;
constexpr int kSteps = 8;
constexpr double kMostLog = 300;  // of a likelihood over the crest's: finite

constexpr Eigen::Index kEliminated = 4, kTerms = 6;
using Terms = Eigen::Matrix<double, kTerms, 1>;

struct Quartic {
  Eigen::Matrix<double, kTerms, kTerms> M;       ///< chi^2 = f^T M f
  Eigen::Matrix<double, kEliminated, kTerms> y;  ///< translation [m], turn about the line of sight [rad]: y f
};

/// \param tilts  two axes across the line of sight
Quartic quartic_of(const CameraFromLandmark& T, const DotSightings& dots, const LandmarkGeometry& landmark,
                   const Eigen::Matrix<double, 3, 2>& tilts, const Eigen::Vector3d& sight) noexcept {
  constexpr Eigen::Index kAll = kEliminated + kTerms;
  Eigen::Matrix<double, kAll, kAll> N = Eigen::Matrix<double, kAll, kAll>::Zero();
  const Eigen::Vector3d a = tilts.col(0), b = tilts.col(1);
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = landmark.centre_m(dot);
    const Eigen::Vector3d q = T.rotation * Eigen::Vector3d(C.x(), 0, C.y()), p = q + T.translation_m;
    Eigen::Matrix<double, 3, kAll> moved;
    moved << Eigen::Matrix3d::Identity(), sight.cross(q), p, a.cross(q), b.cross(q), 0.5 * a.cross(a.cross(q)),
        0.5 * (a.cross(b.cross(q)) + b.cross(a.cross(q))), 0.5 * b.cross(b.cross(q));
    Eigen::Matrix<double, 2, 3> seen;
    seen << Eigen::Matrix2d::Identity(), -dots[dot].ray;
    const Eigen::Matrix<double, 2, kAll> J = seen * moved / p.z();
    N += J.transpose() * dots[dot].information * J;
  }
  Quartic quartic;
  quartic.y = -N.topLeftCorner<kEliminated, kEliminated>().inverse() * N.topRightCorner<kEliminated, kTerms>();
  quartic.M = N.bottomRightCorner<kTerms, kTerms>() + N.bottomLeftCorner<kTerms, kEliminated>() * quartic.y;
  return quartic;
}

}  // namespace

Matrix6d covariance_over_tilts(const CameraFromLandmark& T, const DotSightings& dots, const LandmarkGeometry& landmark,
                               const Matrix6d& covariance) noexcept {
  const Eigen::Vector3d sight = T.translation_m.normalized();
  Eigen::Matrix<double, 3, 2> tilts;
  tilts << sight.unitOrthogonal(), sight.cross(sight.unitOrthogonal());
  const Eigen::Matrix<double, 6, 2> of_tilt = covariance.leftCols<3>() * tilts;
  const Eigen::Matrix2d own = tilts.transpose() * of_tilt.topRows<3>();
  const double sigma_rad = std::sqrt(own.trace());
  const Eigen::Vector3d across = T.rotation.col(1).cross(sight);  // from the normal to the camera's direction
  const double tilt_rad = std::atan2(across.norm(), -sight.dot(T.rotation.col(1)));
  if (!(tilt_rad < kApartSigmas * sigma_rad)) return covariance;

  Quartic chi2 = quartic_of(T, dots, landmark, tilts, sight);
  // The outlines know the curvature at their own crest better than the dots' middles do.
  chi2.M.block<2, 2>(1, 1) = own.inverse();
  chi2.M.block<1, 2>(0, 1).setZero();
  chi2.M.block<2, 1>(1, 0).setZero();
  Eigen::Matrix<double, 6, kTerms> step = Eigen::Matrix<double, 6, kTerms>::Zero();
  step.middleCols<2>(1) = of_tilt * own.inverse();
  step.topRightCorner<3, 3>() = sight * chi2.y.bottomRightCorner<1, 3>();
  step.bottomRightCorner<3, 3>() = chi2.y.topRightCorner<3, 3>();

  const Eigen::Vector2d frontal = -tilt_rad * tilts.transpose() * across.normalized();
  const double pitch_rad = (tilt_rad + kReachSigmas * sigma_rad) / kSteps;
  Eigen::Matrix<double, kTerms, kTerms> moment = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  double sum = 0;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j) {
      const Eigen::Vector2d u = frontal + pitch_rad * Eigen::Vector2d(i, j);
      Terms f;
      f << 1, u.x(), u.y(), u.x() * u.x(), u.x() * u.y(), u.y() * u.y();
      const double likelihood = std::exp(std::min(0.5 * (chi2.M(0, 0) - f.dot(chi2.M * f)), kMostLog));
      sum += likelihood;
      moment += likelihood * f * f.transpose();
    }
  // In place of what the curvature says of the tilt.
  return covariance - step.middleCols<2>(1) * of_tilt.transpose() + step * (moment / sum) * step.transpose();
}

}  // namespace ninedot
