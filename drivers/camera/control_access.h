#pragma once
/// One control after the other of a V4L2 node, with errors in the camera's name.
#include <linux/videodev2.h>

#include <optional>
#include <string>

#include "drivers/camera/video_kernel.h"

namespace ninedot {

/// A value in the driver's own steps; nothing: there is no such control. Threads: any.
std::optional<int> read_control(VideoKernel& kernel, int fd, std::uint32_t id) noexcept;
/// Of controls of 64 bits, such as V4L2_CID_PIXEL_RATE, which the call for 32 bits refuses. \return  the driver's steps
std::optional<std::int64_t> read_long_control(VideoKernel& kernel, int fd, std::uint32_t id) noexcept;

class Controls {
 public:
  /// \param device  how errors call the camera; must outlive this
  Controls(VideoKernel& kernel, int fd, const std::string& device) : kernel_(kernel), fd_(fd), device_(device) {}

  std::optional<v4l2_queryctrl> find(std::uint32_t id) const;
  bool has_choice(std::uint32_t id, int choice_index) const;
  /// In the driver's own steps.
  std::optional<int> read(std::uint32_t id) const { return read_control(kernel_, fd_, id); }
  /// In the driver's own steps. \return  what the driver made of it, in its steps. Throws CameraRefused.
  int write(const v4l2_queryctrl& known, int value, const char* what) const;
  [[noreturn]] void refuse(const std::string& what) const;
  [[noreturn]] void refuse_missing(const char* what, const char* key) const;

 private:
  VideoKernel& kernel_;
  int fd_;
  const std::string& device_;
};

/// \param value  in the driver's own steps \return  the nearest of the steps that the control takes
int clamp_to(const v4l2_queryctrl& control, double value);

/// Lists parts of a sentence.
void add_part(std::string& text, const std::string& part);

}  // namespace ninedot
