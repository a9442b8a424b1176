#pragma once
/// Servos and what powers them, as one head: signals first, power last; power off first, signals last. So nothing
/// jumps.
#include <functional>
#include <memory>

#include "ports/digital_io.h"
#include "ports/pan_tilt.h"

namespace ninedot {

/// Opens the two, as LatePanTilt asks for it. What an attempt got stays open for the next one, so that a head whose
/// power line is missing is not opened again and again. Threads: one at a time.
class PoweredHeadOpener {
 public:
  using OpenServos = std::function<std::unique_ptr<PanTilt>()>;
  using OpenPower = std::function<std::unique_ptr<DigitalOutput>()>;

  /// Both throw as drivers do. \param open_power  empty: the servos have power anyway
  PoweredHeadOpener(OpenServos open_servos, OpenPower open_power)
      : open_servos_(std::move(open_servos)), open_power_(std::move(open_power)) {}

  /// Throws what they throw; DeviceAbsent where the power can't be switched on.
  std::unique_ptr<PanTilt> open();

 private:
  const OpenServos open_servos_;
  const OpenPower open_power_;
  std::unique_ptr<PanTilt> servos_;  // of an attempt that got no power
};

}  // namespace ninedot
