#include "outputs/told_angles.h"

#include <cmath>
#include <utility>

#include "base/units.h"
#include "geometry/euler_angles.h"

namespace ninedot {

ToldAngles told_angles(const Eigen::Matrix3d& R, const Eigen::Matrix3d& covariance,
                       EulerConvention convention) noexcept {
  const YawPitchRoll angles = yaw_pitch_roll(R);
  const Eigen::Vector3d variances_rad2 = covariance_of_angles(angles, covariance).diagonal();
  ToldAngles told{{angles.yaw_rad * kDegPerRad, angles.pitch_rad * kDegPerRad, angles.roll_rad * kDegPerRad}};
  for (std::size_t i = 0; i < 3; ++i)
    told.sigma_deg[i] = std::sqrt(variances_rad2(static_cast<Eigen::Index>(i))) * kDegPerRad;
  // All conventions name the same three turns.
  if (convention == EulerConvention::kFanuc) {
    std::swap(told.angles_deg[0], told.angles_deg[2]);
    std::swap(told.sigma_deg[0], told.sigma_deg[2]);
  }
  return told;
}

}  // namespace ninedot
