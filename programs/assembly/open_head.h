#pragma once
/// From [pan_tilt] and [gpio] of the configuration to a head that stands at its neutral position, under power.
#include <functional>
#include <memory>
#include <string>

#include "config/config.h"
#include "outputs/head_output.h"

namespace ninedot {

/// In the order in which the parts are had. They are given up the other way round: power goes first.
struct OpenedHead {
  std::unique_ptr<DigitalOutput> status_led;   ///< null: none is configured
  std::unique_ptr<DigitalInput> inhibit;       ///< null: none is configured
  std::unique_ptr<PanTilt> servos;             ///< null: driver "none"
  std::unique_ptr<HeadOutput> output;          ///< null: driver "none"
  std::unique_ptr<DigitalOutput> servo_power;  ///< null: none is configured
  std::string description;                     ///< for the log; empty: driver "none"
};

/// Throws StartupError: kWrongUsage when a device or line is missing, in use, or may not be used.
OpenedHead open_head(const Config& config, const CameraModel& camera);

/// What open_head would refuse, part by part; moves and drives nothing.
/// \param attempt  called with a key and a step, which throws StartupError when that key's device can't be used
void check_head(const Config& config,
                const std::function<void(const char* key, const std::function<void()>& step)>& attempt);

}  // namespace ninedot
