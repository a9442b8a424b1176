#pragma once
/// One axis of a head: its angle as the hardware wants it, a pulse width or a position in steps.
#include <array>
#include <cstddef>
#include <span>

#include "ports/pan_tilt.h"

namespace ninedot {

struct AxisPoint {
  double angle_rad = 0;
  double output = 0;  ///< pulse width [us], or position [steps]
};

/// Piecewise linear between the points of a calibration, and on beyond its ends; cut at the output's limits.
/// Memory: inside. Threads: never changed after construction, so any may call anything; nothing waits.
class ServoAxis {
 public:
  static constexpr std::size_t kMaxPoints = 32;  ///< room for one every 3 deg of 90

  /// Whether it can go by this calibration: 2 to kMaxPoints points whose angles rise strictly and whose outputs rise or
  /// fall strictly.
  static bool accepts(std::span<const AxisPoint> points) noexcept;

  /// \param points  accepted (contract)
  /// \param min_output, max_output  [us] or [steps], in this order (contract)
  ServoAxis(std::span<const AxisPoint> points, double min_output, double max_output) noexcept;

  struct Output {
    double value = 0;      ///< [us] or [steps]
    bool limited = false;  ///< cut at a limit
  };
  Output output_at(double angle_rad) const noexcept;
  /// \param output  [us] or [steps]
  /// \return  [rad]
  double angle_at(double output) const noexcept;

 private:
  std::array<AxisPoint, kMaxPoints> points_{};
  std::size_t count_;
  double min_output_, max_output_;
};

/// Threads: as ServoAxis.
struct ServoAxes {
  ServoAxis pan, tilt;
};

}  // namespace ninedot
