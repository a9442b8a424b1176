// Order matters: a manual value is refused, or forgotten, while its automatic is on.
#include "drivers/camera/v4l2_controls.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

namespace ninedot {
namespace {

/// Of V4L2_CID_EXPOSURE_ABSOLUTE: "in 100 us units" (kernel documentation, Camera Control Reference).
constexpr std::chrono::microseconds kExposureUnit{100};
/// A driver whose list never ends must not hang us.
constexpr int kMaxControls = 256;

std::optional<int> read_control(VideoKernel& kernel, int fd, std::uint32_t id) noexcept {
  v4l2_control control{id, 0};
  if (kernel.ioctl(fd, VIDIOC_G_CTRL, &control) < 0) return std::nullopt;
  return control.value;
}

class Controls {
 public:
  Controls(VideoKernel& kernel, int fd, const std::string& device) : kernel_(kernel), fd_(fd), device_(device) {}

  std::optional<v4l2_queryctrl> find(std::uint32_t id) const {
    v4l2_queryctrl control{};
    control.id = id;
    if (kernel_.ioctl(fd_, VIDIOC_QUERYCTRL, &control) < 0 || (control.flags & V4L2_CTRL_FLAG_DISABLED) != 0)
      return std::nullopt;
    return control;
  }
  bool has_choice(std::uint32_t id, int choice) const {
    v4l2_querymenu item{};
    item.id = id;
    item.index = static_cast<std::uint32_t>(choice);
    return kernel_.ioctl(fd_, VIDIOC_QUERYMENU, &item) >= 0;
  }
  std::optional<int> read(std::uint32_t id) const { return read_control(kernel_, fd_, id); }
  /// \return  what the driver made of it
  int write(const v4l2_queryctrl& known, int value, const char* what) const {
    v4l2_control control{known.id, value};
    if (const int error = kernel_.ioctl(fd_, VIDIOC_S_CTRL, &control); error < 0)
      throw CameraRefused(
          fmt::format("{}: the camera refused {} = {} ({})", device_, what, value, std::strerror(-error)), -error);
    return read(known.id).value_or(value);
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw CameraRefused(fmt::format("{}: {}", device_, what), 0);
  }
  [[noreturn]] void refuse_missing(const char* what, const char* key) const {
    throw CameraRefused(fmt::format("{}: the camera has no control for the {}; remove camera.{}", device_, what, key),
                        0);
  }

 private:
  VideoKernel& kernel_;
  int fd_;
  const std::string& device_;
};

int clamp_to(const v4l2_queryctrl& control, double value) {
  return static_cast<int>(
      std::clamp(std::round(value), static_cast<double>(control.minimum), static_cast<double>(control.maximum)));
}

void add(std::string& text, const std::string& part) { text += (text.empty() ? "" : ", ") + part; }

void set_manual_exposure(const Controls& controls, const CameraRequest& request, AppliedControls& applied) {
  const auto exposure = controls.find(V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!exposure) controls.refuse_missing("exposure time", "exposure_us");
  if (const auto automatic = controls.find(V4L2_CID_EXPOSURE_AUTO))
    controls.write(*automatic, V4L2_EXPOSURE_MANUAL, "manual exposure");
  const int units = controls.write(
      *exposure, clamp_to(*exposure, std::chrono::duration<double>(request.exposure) / kExposureUnit), "exposure");
  const double asked_us = std::chrono::duration<double, std::micro>(request.exposure).count();
  const double got_us = std::chrono::duration<double, std::micro>(units * kExposureUnit).count();
  add(applied.description,
      fmt::format("exposure {:g} us{}", got_us, got_us == asked_us ? "" : fmt::format(" (asked {:g})", asked_us)));
}

void set_automatic_exposure(const Controls& controls, AppliedControls& applied) {
  const auto automatic = controls.find(V4L2_CID_EXPOSURE_AUTO);
  if (!automatic) return;
  // Webcams call it aperture priority: they have no iris, so the time is what is left to be automatic.
  for (const int choice : {V4L2_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY})
    if (controls.has_choice(automatic->id, choice)) {
      controls.write(*automatic, choice, "automatic exposure");
      break;
    }
  add(applied.description, "exposure automatic");
}

void set_gain(const Controls& controls, const CameraRequest& request, AppliedControls& applied) {
  const auto automatic = controls.find(V4L2_CID_AUTOGAIN);
  if (request.gain <= 0) {
    if (automatic) controls.write(*automatic, 1, "automatic gain");
    return;
  }
  auto gain = controls.find(V4L2_CID_GAIN);
  if (!gain) gain = controls.find(V4L2_CID_ANALOGUE_GAIN);
  if (!gain) controls.refuse_missing("gain", "gain");
  if (automatic) controls.write(*automatic, 0, "manual gain");
  const int asked = clamp_to(*gain, request.gain);
  const int got = controls.write(*gain, asked, "gain");
  add(applied.description,
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
  add(applied.description, fmt::format("flicker {}", name));
}

void set_fixed_focus(const Controls& controls, const CameraRequest& request, AppliedControls& applied) {
  const auto automatic = controls.find(V4L2_CID_FOCUS_AUTO);
  const auto position = controls.find(V4L2_CID_FOCUS_ABSOLUTE);
  if (!automatic && !position) controls.refuse_missing("focus", "focus");
  if (automatic && controls.write(*automatic, 0, "manual focus") != 0)
    controls.refuse("autofocus stays on although camera.focus is \"fixed\"; use another camera");
  if (!position) return add(applied.description, "focus fixed");
  if (!(request.focus_position >= position->minimum && request.focus_position <= position->maximum))
    controls.refuse(fmt::format("set camera.focus_position, from {} to {}; it is {} now", position->minimum,
                                position->maximum, controls.read(position->id).value_or(position->default_value)));
  const int got = controls.write(*position, clamp_to(*position, request.focus_position), "focus");
  add(applied.description,
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
  if (is_on) add(applied.description, "focus automatic");
}

}  // namespace

AppliedControls apply_controls(VideoKernel& kernel, int fd, const CameraRequest& request) {
  const Controls controls(kernel, fd, request.device);
  AppliedControls applied;
  set_power_line(controls, request.power_line, applied);
  if (const auto priority = controls.find(V4L2_CID_EXPOSURE_AUTO_PRIORITY))
    controls.write(*priority, request.lower_rate_in_the_dark ? 1 : 0, "exposure priority");
  if (request.exposure.count() > 0)
    set_manual_exposure(controls, request, applied);
  else
    set_automatic_exposure(controls, applied);
  set_gain(controls, request, applied);
  set_focus(controls, request, applied);
  applied.now = read_live_controls(kernel, fd);
  return applied;
}

LiveControls read_live_controls(VideoKernel& kernel, int fd) noexcept {
  LiveControls now;
  if (const auto units = read_control(kernel, fd, V4L2_CID_EXPOSURE_ABSOLUTE)) now.exposure = *units * kExposureUnit;
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
