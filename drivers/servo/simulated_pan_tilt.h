#pragma once
/// A head that exists in memory only: it stands at once where it is told to.
#include "aim/servo_axis.h"

namespace ninedot {

/// Memory: inside. Threads: one caller for all methods; nothing waits.
class SimulatedPanTilt : public PanTilt {
 public:
  SimulatedPanTilt(const ServoAxes& axes, const HeadAngles& at) noexcept : axes_(axes) { move_to(at); }
  void move_to(const HeadAngles& angles) noexcept override {
    const ServoAxis::Output pan = axes_.pan.output_at(angles.pan_rad), tilt = axes_.tilt.output_at(angles.tilt_rad);
    state_.angles = {axes_.pan.angle_at(pan.value), axes_.tilt.angle_at(tilt.value)};
    state_.limited = pan.limited || tilt.limited;
  }
  void stop() noexcept override {}
  HeadState state() const noexcept override { return state_; }

 private:
  const ServoAxes axes_;
  HeadState state_;
};

}  // namespace ninedot
