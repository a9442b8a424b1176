#pragma once
/// Servos, or a pan/tilt camera, and what powers them, as one head.
#include <cstdint>
#include <functional>
#include <memory>

#include "ports/digital_io.h"
#include "ports/pan_tilt.h"

namespace ninedot {

enum class PowerComes : std::uint8_t {
  kLast,   ///< and goes first: servos without a signal jump
  kFirst,  ///< and goes last: a camera answers under power only
};

/// Opens the two, as LatePanTilt asks for it. What an attempt got stays open for the next one: a head whose power line
/// is missing is not opened again and again, and a camera that starts up keeps its power. Threads: one at a time.
class PoweredHeadOpener {
 public:
  /// \param at  where the head is taken to be
  using OpenServos = std::function<std::unique_ptr<PanTilt>(const HeadAngles& at)>;
  using OpenPower = std::function<std::unique_ptr<DigitalOutput>()>;

  /// Both throw as drivers do. \param open_power  empty: the servos have power anyway
  PoweredHeadOpener(OpenServos open_servos, OpenPower open_power, PowerComes power_comes)
      : open_servos_(std::move(open_servos)), open_power_(std::move(open_power)), power_comes_(power_comes) {}

  /// Throws what they throw; DeviceAbsent where the power can't be switched on.
  std::unique_ptr<PanTilt> open(const HeadAngles& at);

 private:
  const OpenServos open_servos_;
  const OpenPower open_power_;
  const PowerComes power_comes_;
  // Of an attempt that got no more.
  std::unique_ptr<PanTilt> servos_;
  std::unique_ptr<DigitalOutput> power_;
};

}  // namespace ninedot
