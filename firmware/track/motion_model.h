#pragma once
/// How a camera goes on: at constant velocity and turning rate, disturbed by accelerations that are white noise.
///
/// Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation", Wiley 2001,
/// section 6.2.2 (continuous white-noise acceleration), on SE(3) with the errors of world/sighting_fit.h.
#include <Eigen/Core>

#include "world/sighting_fit.h"

namespace ninedot {

struct CameraMotion {
  WorldFromCamera T_world_camera;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();            ///< of the optical centre, world axes
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  ///< camera axes
};

/// (position [m, world], rotation [rad, camera], velocity [m/s, world], angular velocity [rad/s, camera]); the first
/// six are a PoseStep.
using MotionStep = Eigen::Matrix<double, 12, 1>;
using MotionCovariance = Eigen::Matrix<double, 12, 12>;

/// \param step  in m, rad, m/s and rad/s
CameraMotion moved_by(const CameraMotion& motion, const MotionStep& step) noexcept;
/// In m, rad, m/s and rad/s: moved_by(from, step_between(from, to)) == to.
MotionStep step_between(const CameraMotion& from, const CameraMotion& to) noexcept;

/// Spectral densities of the accelerations about each axis.
struct MotionNoise {
  double linear_m2_s3 = 0;     ///< [m^2/s^3]
  double angular_rad2_s3 = 0;  ///< [rad^2/s^3]
};

/// One step of `dt_s` > 0 seconds from `motion`. Memory: none. Threads: pure.
class MotionPrediction {
 public:
  MotionPrediction(const CameraMotion& motion, double dt_s) noexcept;

  CameraMotion motion() const noexcept;
  /// F X: what becomes of errors, one in each column, in m, rad, m/s and rad/s. \param errors  MotionSteps, in the
  /// same: m, rad, ...
  template <int Columns>
  Eigen::Matrix<double, 12, Columns> carried(const Eigen::Matrix<double, 12, Columns>& errors) const noexcept {
    Eigen::Matrix<double, 12, Columns> X = errors;
    X.template topRows<3>() += dt_s_ * errors.template middleRows<3>(6);
    X.template middleRows<3>(3) =
        turned_back_ * errors.template middleRows<3>(3) + rate_to_turn_ * errors.template bottomRows<3>();
    return X;
  }
  /// F P F^T + Q, in m, rad, m/s and rad/s. \param covariance  of MotionSteps, in m, rad, ...
  MotionCovariance covariance(const MotionCovariance& covariance, const MotionNoise& noise) const noexcept;

 private:
  CameraMotion from_;
  double dt_s_;
  Eigen::Matrix3d turned_back_;   // of rotation errors, into the axes of the turned camera
  Eigen::Matrix3d rate_to_turn_;  // of errors of the turning rate [s]
};

}  // namespace ninedot
