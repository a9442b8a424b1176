#include "geometry/upright_prior.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/units.h"

namespace ninedot {
namespace {

// Priors, chosen and not measured. Roll: hand-levelled mounts on uneven floors, so that half an eighth of a turn is
// 1.6 sigma, and the neighbour of the right numbering has odds of 1 to 170 where the camera is level. Elevation: weak,
// for cameras hang under ceilings too.
constexpr double kRollSigma_rad = 14 * kRadPerDeg;
constexpr double kElevationSigma_rad = 50 * kRadPerDeg;

}  // namespace

NumberingCosts upright_costs(const Eigen::Vector3d& X_camera, const Eigen::Vector3d& Z_camera,
                             const Eigen::Vector3d& to_camera, const LandmarkGeometry& landmark,
                             double expected_roll_rad) noexcept {
  NumberingCosts costs{};
  for (std::size_t k = 0; k < kRingDotCount; ++k) {
    const Eigen::Vector2d towards = landmark.centre_m(k).normalized();
    const Eigen::Vector3d up = -(towards.x() * X_camera + towards.y() * Z_camera);
    const double roll_rad = std::remainder(std::atan2(up.x(), -up.y()) - expected_roll_rad, 2 * std::numbers::pi);
    const double elevation_rad = std::asin(std::clamp(up.dot(to_camera), -1.0, 1.0));
    costs[k] = std::pow(roll_rad / kRollSigma_rad, 2) + std::pow(elevation_rad / kElevationSigma_rad, 2);
  }
  return costs;
}

}  // namespace ninedot
