#pragma once
/// What differs between the versions of libcamera that we build with: 0.0.3 (Debian 12), 0.4 (Debian 13), 0.5 and
/// later.
#include <libcamera/control_ids.h>
#include <libcamera/controls.h>
#include <libcamera/version.h>

#include <chrono>

#define NINEDOT_LIBCAMERA_HAS_EXPOSURE_MODES (LIBCAMERA_VERSION_MAJOR > 0 || LIBCAMERA_VERSION_MINOR >= 5)

namespace ninedot::shim {

/// Whether the camera has a control of its own for these; without one the value can't be asked for.
inline bool has_exposure(const libcamera::ControlInfoMap& known) {
  return known.find(&libcamera::controls::ExposureTime) != known.end();
}
inline bool has_gain(const libcamera::ControlInfoMap& known) {
  return known.find(&libcamera::controls::AnalogueGain) != known.end();
}

/// Manual values for what is above zero, automatic for the rest. From 0.5 each has a mode and is ignored unless that is
/// manual; before, one switch serves both, and a single manual value holds while the other stays automatic.
inline void set_exposure_and_gain(libcamera::ControlList& controls, const libcamera::ControlInfoMap& known,
                                  std::chrono::microseconds exposure, float gain) {
  namespace ids = libcamera::controls;
#if NINEDOT_LIBCAMERA_HAS_EXPOSURE_MODES
  if (known.find(&ids::ExposureTimeMode) != known.end())
    controls.set(ids::ExposureTimeMode, exposure.count() > 0 ? ids::ExposureTimeModeManual : ids::ExposureTimeModeAuto);
  if (known.find(&ids::AnalogueGainMode) != known.end())
    controls.set(ids::AnalogueGainMode, gain > 0 ? ids::AnalogueGainModeManual : ids::AnalogueGainModeAuto);
#else
  if (known.find(&ids::AeEnable) != known.end()) controls.set(ids::AeEnable, !(exposure.count() > 0 && gain > 0));
#endif
  if (exposure.count() > 0) controls.set(ids::ExposureTime, static_cast<std::int32_t>(exposure.count()));
  if (gain > 0) controls.set(ids::AnalogueGain, gain);
}

}  // namespace ninedot::shim
