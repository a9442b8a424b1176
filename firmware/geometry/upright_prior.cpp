#include "geometry/upright_prior.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/units.h"

namespace ninedot {
namespace {

// Nobody knows how well a mount is levelled to better than a quarter of it: what is configured counts as that much
// more.
constexpr double kSigmaDoubt = 1.25;

// Chosen and not measured: weak, for cameras hang under ceilings too.
constexpr double kElevationSigma_rad = 50 * kRadPerDeg;

}  // namespace

NumberingCosts upright_costs(const Eigen::Vector3d& X_camera, const Eigen::Vector3d& Z_camera,
                             const Eigen::Vector3d& to_camera, const LandmarkGeometry& landmark,
                             const UprightPrior& prior) noexcept {
  NumberingCosts costs{};
  for (std::size_t k = 0; k < kRingDotCount; ++k) {
    const Eigen::Vector2d towards = landmark.centre_m(k).normalized();
    const Eigen::Vector3d up = -(towards.x() * X_camera + towards.y() * Z_camera);
    const double roll_rad = std::remainder(std::atan2(up.x(), -up.y()) - prior.expected_roll_rad, 2 * std::numbers::pi);
    const double elevation_rad = std::asin(std::clamp(up.dot(to_camera), -1.0, 1.0));
    costs[k] =
        std::pow(roll_rad / (kSigmaDoubt * prior.roll_sigma_rad), 2) + std::pow(elevation_rad / kElevationSigma_rad, 2);
  }
  return costs;
}

}  // namespace ninedot
