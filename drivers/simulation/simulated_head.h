#pragma once
/// The head that a simulated camera sits on, as a PanTilt: its commands go to the camera, which moves the servos.
///
/// Like a head on PWM it does not know where it stands: it says where it was last told to.
#include <array>
#include <cstdint>
#include <memory>

#include "base/handoff.h"
#include "drivers/simulation/simulation_clock.h"
#include "ports/pan_tilt.h"

namespace ninedot {

/// The newest commands to the head, and how many there were.
struct HeadCommands {
  struct Command {
    MonoTime at{};
    HeadAngles angles;
  };
  std::array<Command, 64> list{};  ///< number n in place n modulo 64
  std::uint64_t count = 0;         ///< since the start

  void add(MonoTime at, const HeadAngles& angles) noexcept { list[count++ % list.size()] = {at, angles}; }
};

/// From the head's thread to the camera's; neither waits. It outlasts heads: one may be closed and another one opened.
struct HeadLine {
  HeadCommands told;  ///< the head's own
  Handoff<HeadCommands> newest;
};

/// Memory: inside. Threads: one caller for all methods; nothing waits.
class SimulatedHead final : public PanTilt {
 public:
  /// Tells the servos to go to `at`. \param clock  must outlive this
  SimulatedHead(std::shared_ptr<HeadLine> line, const SimulationClock& clock, const HeadAngles& at) noexcept
      : line_(std::move(line)), clock_(clock) {
    tell(at);
  }
  void move_to(const HeadAngles& angles) noexcept override {
    if (angles.pan_rad != state_.angles.pan_rad || angles.tilt_rad != state_.angles.tilt_rad) tell(angles);
  }
  void stop() noexcept override {}
  HeadState state() const noexcept override { return state_; }

 private:
  void tell(const HeadAngles& angles) noexcept {
    state_.angles = angles;
    line_->told.add(clock_.now(), angles);
    line_->newest.put(line_->told);
  }

  const std::shared_ptr<HeadLine> line_;
  const SimulationClock& clock_;
  HeadState state_;
};

}  // namespace ninedot
