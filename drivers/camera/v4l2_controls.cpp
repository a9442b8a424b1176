// Order matters: a manual value is refused, or forgotten, while its automatic is on.
#include "drivers/camera/v4l2_controls.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "drivers/camera/control_access.h"

namespace ninedot {
namespace {

/// Of V4L2_CID_EXPOSURE_ABSOLUTE: "in 100 us units" (kernel documentation, Camera Control Reference).
constexpr std::chrono::microseconds kExposureUnit{100};
/// A driver whose list never ends must not hang us.
constexpr int kMaxControls = 256;

double in_us(std::chrono::nanoseconds time) { return static_cast<double>(time.count()) / 1e3; }

void add_exposure(std::chrono::nanoseconds got, std::chrono::nanoseconds asked, bool is_same, std::string& text) {
  add_part(text, fmt::format("exposure {:.6g} us{}", in_us(got),
                             is_same ? "" : fmt::format(" (asked {:.6g})", in_us(asked))));
}

void switch_to_manual(const Controls& controls) {
  if (const auto automatic = controls.find(V4L2_CID_EXPOSURE_AUTO))
    controls.write(*automatic, V4L2_EXPOSURE_MANUAL, "manual exposure");
}

void set_manual_exposure(const Controls& controls, const CameraRequest& request, AppliedControls& applied) {
  const auto exposure = controls.find(V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!exposure) controls.refuse_missing("exposure time", "exposure_us");
  switch_to_manual(controls);
  const int units = controls.write(
      *exposure, clamp_to(*exposure, std::chrono::duration<double>(request.exposure) / kExposureUnit), "exposure");
  const std::chrono::nanoseconds got = units * kExposureUnit;
  add_exposure(got, request.exposure, got == request.exposure, applied.description);
}

/// In whole lines; within half of one it is what was asked for. The driver's range, which the blanking has just
/// changed, may leave out that an exposure ends with its frame.
void set_exposure_lines(const Controls& controls, const CameraRequest& request, const SensorTiming& sensor,
                        AppliedControls& applied) {
  const auto exposure = controls.find(V4L2_CID_EXPOSURE);
  if (!exposure) controls.refuse_missing("exposure time", "exposure_us");
  if (!sensor.is_known())
    controls.refuse("the sensor does not tell its line time, in which its exposure counts; remove camera.exposure_us");
  switch_to_manual(controls);
  const double asked = std::min(sensor.lines_in(request.exposure), static_cast<double>(sensor.frame_lines));
  const int lines = controls.write(*exposure, clamp_to(*exposure, asked), "exposure");
  const auto got = sensor.of_lines(lines);
  add_exposure(got, request.exposure, 2 * std::chrono::abs(got - request.exposure) <= sensor.line_time(),
               applied.description);
}

void set_automatic_exposure(const Controls& controls, const SensorTiming* sensor, AppliedControls& applied) {
  const auto automatic = controls.find(V4L2_CID_EXPOSURE_AUTO);
  if (!automatic && sensor != nullptr && applied.now.exposure.count() > 0)
    add_part(applied.description, fmt::format("exposure {:.6g} us as it was", in_us(applied.now.exposure)));
  if (!automatic) return;
  // Webcams call it aperture priority: they have no iris, so the time is what is left to be automatic.
  for (const int choice : {V4L2_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY})
    if (controls.has_choice(automatic->id, choice)) {
      controls.write(*automatic, choice, "automatic exposure");
      break;
    }
  add_part(applied.description, "exposure automatic");
}

void set_gain(const Controls& controls, const CameraRequest& request, const SensorTiming* sensor,
              AppliedControls& applied) {
  const auto automatic = controls.find(V4L2_CID_AUTOGAIN);
  // A sensor may have a digital one as well, which makes noise brighter and nothing else.
  auto gain = controls.find(sensor != nullptr ? V4L2_CID_ANALOGUE_GAIN : V4L2_CID_GAIN);
  if (!gain) gain = controls.find(sensor != nullptr ? V4L2_CID_GAIN : V4L2_CID_ANALOGUE_GAIN);
  if (request.gain <= 0) {
    if (automatic) controls.write(*automatic, 1, "automatic gain");
    if (!automatic && sensor != nullptr && gain)
      add_part(applied.description, fmt::format("gain {} as it was", controls.read(gain->id).value_or(0)));
    return;
  }
  if (!gain) controls.refuse_missing("gain", "gain");
  if (automatic) controls.write(*automatic, 0, "manual gain");
  const int asked = clamp_to(*gain, request.gain);
  const int got = controls.write(*gain, asked, "gain");
  add_part(applied.description,
           fmt::format("gain {}{}", got, got == request.gain ? "" : fmt::format(" (asked {:g})", request.gain)));
}

void set_power_line(const Controls& controls, PowerLine power_line, AppliedControls& applied) {
  if (power_line == PowerLine::kUnchanged) return;
  const auto control = controls.find(V4L2_CID_POWER_LINE_FREQUENCY);
  if (!control) controls.refuse_missing("power-line frequency", "power_line");
  int value = V4L2_CID_POWER_LINE_FREQUENCY_AUTO;
  const char* name = "automatic";
  if (power_line == PowerLine::kOff) value = V4L2_CID_POWER_LINE_FREQUENCY_DISABLED, name = "off";
  if (power_line == PowerLine::k50Hz) value = V4L2_CID_POWER_LINE_FREQUENCY_50HZ, name = "50 Hz";
  if (power_line == PowerLine::k60Hz) value = V4L2_CID_POWER_LINE_FREQUENCY_60HZ, name = "60 Hz";
  controls.write(*control, value, "power-line frequency");
  add_part(applied.description, fmt::format("flicker {}", name));
}

void set_fixed_focus(const Controls& controls, const CameraRequest& request, AppliedControls& applied) {
  const auto automatic = controls.find(V4L2_CID_FOCUS_AUTO);
  const auto position = controls.find(V4L2_CID_FOCUS_ABSOLUTE);
  if (!automatic && !position) controls.refuse_missing("focus", "focus");
  if (automatic && controls.write(*automatic, 0, "manual focus") != 0)
    controls.refuse("autofocus stays on although camera.focus is \"fixed\"; use another camera");
  if (!position) return add_part(applied.description, "focus fixed");
  if (!(request.focus_position >= position->minimum && request.focus_position <= position->maximum))
    controls.refuse(fmt::format("set camera.focus_position, from {} to {}; it is {} now", position->minimum,
                                position->maximum, controls.read(position->id).value_or(position->default_value)));
  const int got = controls.write(*position, clamp_to(*position, request.focus_position), "focus");
  add_part(applied.description,
           fmt::format("focus {}{}", got,
                       got == request.focus_position ? "" : fmt::format(" (asked {:g})", request.focus_position)));
}

/// A lens that focuses anew has another focal length and another middle than the calibrated ones.
void set_focus(const Controls& controls, const CameraRequest& request, AppliedControls& applied) {
  if (request.focus == Focus::kFixed) return set_fixed_focus(controls, request, applied);
  const auto automatic = controls.find(V4L2_CID_FOCUS_AUTO);
  if (request.focus == Focus::kAutomatic && !automatic) controls.refuse_missing("automatic focus", "focus");
  if (!automatic) return;
  const bool is_on = request.focus == Focus::kAutomatic || controls.read(automatic->id).value_or(1) != 0;
  if (is_on && request.is_calibrated) {
    const auto position = controls.find(V4L2_CID_FOCUS_ABSOLUTE);
    controls.refuse(
        fmt::format("autofocus is on, and a calibration holds for one focus only: set camera.focus = \"fixed\"{}",
                    position ? fmt::format(" and camera.focus_position, from {} to {}, that of the calibration",
                                           position->minimum, position->maximum)
                             : ""));
  }
  if (request.focus == Focus::kAutomatic) controls.write(*automatic, 1, "automatic focus");
  if (is_on) add_part(applied.description, "focus automatic");
}

}  // namespace

AppliedControls apply_controls(VideoKernel& kernel, int fd, const CameraRequest& request, const SensorTiming* sensor) {
  const Controls controls(kernel, fd, request.device);
  AppliedControls applied;
  if (sensor != nullptr) applied.now = read_live_controls(kernel, fd, sensor);  // of a USB camera it takes its time
  set_power_line(controls, request.power_line, applied);
  if (const auto priority = controls.find(V4L2_CID_EXPOSURE_AUTO_PRIORITY))
    controls.write(*priority, request.lower_rate_in_the_dark ? 1 : 0, "exposure priority");
  if (request.exposure.count() == 0)
    set_automatic_exposure(controls, sensor, applied);
  else if (sensor != nullptr)
    set_exposure_lines(controls, request, *sensor, applied);
  else
    set_manual_exposure(controls, request, applied);
  set_gain(controls, request, sensor, applied);
  set_focus(controls, request, applied);
  applied.now = read_live_controls(kernel, fd, sensor);
  return applied;
}

LiveControls read_live_controls(VideoKernel& kernel, int fd, const SensorTiming* sensor) noexcept {
  LiveControls now;
  if (sensor == nullptr) {
    if (const auto units = read_control(kernel, fd, V4L2_CID_EXPOSURE_ABSOLUTE)) now.exposure = *units * kExposureUnit;
  } else if (sensor->is_known()) {
    if (const auto lines = read_control(kernel, fd, V4L2_CID_EXPOSURE)) now.exposure = sensor->of_lines(*lines);
  }
  if (const auto steps = read_control(kernel, fd, V4L2_CID_ZOOM_ABSOLUTE)) now.zoom = *steps;
  return now;
}

std::vector<std::string> describe_controls(VideoKernel& kernel, int fd) {
  std::vector<std::string> lines;
  v4l2_queryctrl control{};
  control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (int i = 0; i < kMaxControls && kernel.ioctl(fd, VIDIOC_QUERYCTRL, &control) >= 0; ++i) {
    const bool has_value = control.type == V4L2_CTRL_TYPE_INTEGER || control.type == V4L2_CTRL_TYPE_BOOLEAN ||
                           control.type == V4L2_CTRL_TYPE_MENU;
    if (has_value && (control.flags & V4L2_CTRL_FLAG_DISABLED) == 0) {
      v4l2_control now{control.id, 0};
      const bool is_known = kernel.ioctl(fd, VIDIOC_G_CTRL, &now) >= 0;
      const auto* const name = reinterpret_cast<const char*>(control.name);
      lines.push_back(fmt::format("{}: {} to {} step {}{}", std::string(name, ::strnlen(name, sizeof control.name)),
                                  control.minimum, control.maximum, control.step,
                                  is_known ? fmt::format(", now {}", now.value) : ""));
    }
    control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return lines;
}

}  // namespace ninedot
