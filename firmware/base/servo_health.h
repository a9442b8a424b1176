#pragma once
/// What servos tell about themselves.
#include <limits>

namespace ninedot {

/// Of pan and tilt the worse; NaN: they don't tell. Trivially copyable.
struct ServoHealth {
  double load_percent = kUnknown;  ///< of the largest that the servo can give; its size, without a sign
  double supply_V = kUnknown;      ///< [V] the lower of both
  double temperature_degC = kUnknown;

  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();  ///< [1]
};

}  // namespace ninedot
