#pragma once
/// What differs between the versions of libcamera that we build with: 0.0.3 (Debian 12), 0.4 (Debian 13), 0.5 and
/// later.
#include <libcamera/control_ids.h>
#include <libcamera/controls.h>
#include <libcamera/version.h>

#include <chrono>
#include <optional>

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

inline bool has_autofocus(const libcamera::ControlInfoMap& known) {
  return known.find(&libcamera::controls::AfMode) != known.end();
}

/// Of LensPosition [1/m].
struct FocusRange {
  double least_per_m = 0, most_per_m = 0;
};
inline std::optional<FocusRange> focus_range(const libcamera::ControlInfoMap& known) {
  const auto lens = known.find(&libcamera::controls::LensPosition);
  if (lens == known.end()) return std::nullopt;
  return FocusRange{static_cast<double>(lens->second.min().get<float>()),
                    static_cast<double>(lens->second.max().get<float>())};
}

/// \param position_per_m  for a fixed lens that can be moved
inline void set_focus(libcamera::ControlList& controls, const libcamera::ControlInfoMap& known,
                      std::optional<float> position_per_m, bool is_fixed) {
  namespace ids = libcamera::controls;
  if (has_autofocus(known)) controls.set(ids::AfMode, is_fixed ? ids::AfModeManual : ids::AfModeContinuous);
  if (position_per_m) controls.set(ids::LensPosition, *position_per_m);
}

}  // namespace ninedot::shim
