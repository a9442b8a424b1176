#pragma once
/// From [pan_tilt] and [gpio] of the configuration to a head under power, as soon
/// as its devices are there.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/config.h"
#include "drivers/simulation/simulated_head.h"
#include "outputs/head_output.h"
#include "programs/assembly/watched_device.h"

namespace ninedot {

/// In the order in which the parts are had. They are given up the other way round. Each may come late: the lamp and the
/// servos' power are opened by whoever sets them, input and head by threads of their own.
struct OpenedHead {
  std::unique_ptr<DigitalOutput> status_led;  ///< null: none is configured
  std::unique_ptr<DigitalInput> inhibit;      ///< null: none is configured
  std::unique_ptr<PanTilt> servos;     ///< null: driver "none". With their power, which goes on last and off first
  std::unique_ptr<HeadOutput> output;  ///< null: driver "none"
  /// Power with driver "none", to be set again and again; else null.
  std::unique_ptr<DigitalOutput> lone_power;
  std::vector<WatchedDevice> devices;  ///< those above that are configured
};

/// Opens what is there; what is not, in use, or not permitted is waited for. While the inhibit input is active or not
/// there the head is not opened, because a servo may move as it gets its first pulse.
/// Throws StartupError(kWrongUsage) for what no waiting mends: a channel or offset that its chip does not have, a
/// device that is no serial port.
/// \param head_line  to the servos of a simulated camera, for driver "simulated"; null: that head is in memory only
/// \param follows_zoom  its zoom may move, and is asked for again and again where it can tell it
OpenedHead open_head(const Config& config, const CameraModel& camera, const std::shared_ptr<HeadLine>& head_line,
                     bool follows_zoom);

/// A head that tells where its zoom stands, for who does not move it; null: that of the configuration can't. One that
/// is not there is waited for. Throws likewise.
std::unique_ptr<PanTilt> open_zoom_teller(const Config& config);

/// What open_head would refuse or wait for, part by part; moves and drives nothing.
/// \param attempt  called with a key and a step, which throws as the devices' drivers do: DeviceAbsent, StartupError
void check_head(const Config& config,
                const std::function<void(const char* key, const std::function<void()>& step)>& attempt);

}  // namespace ninedot
