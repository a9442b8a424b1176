#pragma once
/// A rotation as the three angles that a controller asks for, and how certain each of them is.
#include <Eigen/Core>
#include <array>

#include "proto/wire_report.h"

namespace ninedot {

/// Yaw, pitch, roll; W, P, R; or A, B, C: see geometry/euler_angles.h.
struct ToldAngles {
  std::array<double, 3> angles_deg{};
  std::array<double, 3> sigma_deg{};  ///< 1-sigma of each; without bound where the pitch is at +-90 deg
};

/// \param R  rotation matrix [1] \param covariance  of a rotation vector in the turned axes, R exp(rotation) [rad^2]
/// Memory: none. Threads: pure.
ToldAngles told_angles(const Eigen::Matrix3d& R, const Eigen::Matrix3d& covariance,
                       EulerConvention convention) noexcept;

}  // namespace ninedot
