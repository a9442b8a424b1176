#include "drivers/camera/control_access.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "drivers/camera/camera_device.h"

namespace ninedot {

std::optional<int> read_control(VideoKernel& kernel, int fd, std::uint32_t id) noexcept {
  v4l2_control control{id, 0};
  if (kernel.ioctl(fd, VIDIOC_G_CTRL, &control) < 0) return std::nullopt;
  return control.value;
}

std::optional<std::int64_t> read_long_control(VideoKernel& kernel, int fd, std::uint32_t id) noexcept {
  v4l2_ext_control control{};
  control.id = id;
  v4l2_ext_controls list{};
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &control;
  if (kernel.ioctl(fd, VIDIOC_G_EXT_CTRLS, &list) < 0) return std::nullopt;
  return std::int64_t{control.value64};
}

std::optional<v4l2_queryctrl> Controls::find(std::uint32_t id) const {
  v4l2_queryctrl control{};
  control.id = id;
  if (kernel_.ioctl(fd_, VIDIOC_QUERYCTRL, &control) < 0 || (control.flags & V4L2_CTRL_FLAG_DISABLED) != 0)
    return std::nullopt;
  return control;
}

bool Controls::has_choice(std::uint32_t id, int choice_index) const {
  v4l2_querymenu item{};
  item.id = id;
  item.index = static_cast<std::uint32_t>(choice_index);
  return kernel_.ioctl(fd_, VIDIOC_QUERYMENU, &item) >= 0;
}

int Controls::write(const v4l2_queryctrl& known, int value, const char* what) const {
  v4l2_control control{known.id, value};
  if (const int error = kernel_.ioctl(fd_, VIDIOC_S_CTRL, &control); error < 0)
    throw CameraRefused(fmt::format("{}: the camera refused {} = {} ({})", device_, what, value, std::strerror(-error)),
                        -error);
  return read(known.id).value_or(value);
}

void Controls::refuse(const std::string& what) const { throw CameraRefused(fmt::format("{}: {}", device_, what), 0); }

void Controls::refuse_missing(const char* what, const char* key) const {
  throw CameraRefused(fmt::format("{}: the camera has no control for the {}; remove camera.{}", device_, what, key), 0);
}

int clamp_to(const v4l2_queryctrl& control, double value) {
  return static_cast<int>(
      std::clamp(std::round(value), static_cast<double>(control.minimum), static_cast<double>(control.maximum)));
}

void add_part(std::string& text, const std::string& part) { text += (text.empty() ? "" : ", ") + part; }

}  // namespace ninedot
