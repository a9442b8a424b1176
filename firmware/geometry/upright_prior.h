#pragma once
/// How likely each numbering of the ring is before anything is known of the camera but that it stands upright.
///
/// The ring looks the same after an eighth of a turn, so that one picture allows eight cameras. Cameras are mounted
/// level, but for the expected roll, and not far above or below a landmark: roll and elevation are taken as normal.
#include <array>
#include <numbers>

#include "geometry/landmark.h"
#include "geometry/transform.h"

namespace ninedot {

/// How the camera is mounted.
struct UprightPrior {
  double expected_roll_rad = 0;  ///< roll of the camera about its optical axis at which P1 is the lowest dot
  /// 1-sigma of the roll about that: 5 degrees, a bracket levelled by hand on an uneven floor.
  double roll_sigma_rad = 5 * std::numbers::pi / 180;
};

/// What speaks against the dot at index k being P1, as squares of normal deviates: (roll / sigma)^2 + (elevation /
/// sigma)^2 of the camera that it would make.
using NumberingCosts = std::array<double, kRingDotCount>;

/// \param X_camera, Z_camera  the sheet's axes X0 and Z0, frame camera, length 1 [1]
/// \param to_camera  from the sheet's P9 to the camera, frame camera, length 1 [1]
/// \return  squares of normal deviates [1]
/// Memory: none. Threads: pure.
NumberingCosts upright_costs(const Eigen::Vector3d& X_camera, const Eigen::Vector3d& Z_camera,
                             const Eigen::Vector3d& to_camera, const LandmarkGeometry& landmark,
                             const UprightPrior& prior) noexcept;

/// The same of a pose [1].
inline NumberingCosts upright_costs(const CameraFromLandmark& T, const LandmarkGeometry& landmark,
                                    const UprightPrior& prior) noexcept {
  return upright_costs(T.rotation.col(0), T.rotation.col(2), -T.translation_m.normalized(), landmark, prior);
}

}  // namespace ninedot
