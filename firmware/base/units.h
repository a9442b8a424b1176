#pragma once
/// From the units of files, registers and people to those inside: metres and radians.
#include <numbers>

namespace ninedot {

inline constexpr double kRadPerDeg = std::numbers::pi / 180,
                        kDegPerRad = 180 / std::numbers::pi;  ///< [rad/deg], [deg/rad]
inline constexpr double kMetresPerMm = 1e-3;                  ///< [m/mm]

}  // namespace ninedot
