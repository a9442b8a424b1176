#pragma once
/// A made-up kernel with one V4L2 camera in it, for the faults that a real one shows once a month.
#include <linux/videodev2.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "drivers/camera/pixel_format.h"
#include "drivers/camera/video_kernel.h"

namespace ninedot {

class FakeVideoKernel final : public VideoKernel {
 public:
  static constexpr int kFd = 7;
  struct Format {
    std::uint32_t fourcc;
    std::vector<std::array<int, 2>> sizes;
    std::uint32_t rate_hz;
  };
  struct Filled {
    std::uint32_t sequence = 0;
    MonoTime stamp{};
    std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    std::uint32_t bytes = 0;  // 0 = the whole buffer
  };

  // What the camera is.
  int open_error = 0;
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::string card, bus_info;
  std::vector<Format> formats;
  std::map<std::uint32_t, v4l2_queryctrl> controls;
  std::map<std::uint32_t, int> values;
  std::uint32_t input_status = 0;
  std::uint32_t given_buffers = 4;
  std::uint32_t stride_bytes = 0;
  std::map<unsigned long, int> refusals;  // request -> errno
  // What it does.
  int dqbuf_error = 0;
  int events = 0;  // what poll says beside POLLIN

  // What was done to it.
  bool is_open = false, is_streaming = false;
  int opened = 0, mapped = 0;
  // Reserved, so that a test may count the driver's heap calls and meets none of the fake's.
  std::vector<std::uint32_t> queued;
  std::vector<v4l2_buffer> filled;
  std::vector<std::vector<std::uint8_t>> memory;
  std::vector<std::pair<std::uint32_t, int>> written;  // controls, in order

  void add_control(std::uint32_t id, int minimum, int maximum, int value) {
    v4l2_queryctrl control{};
    control.id = id, control.minimum = minimum, control.maximum = maximum, control.step = 1;
    control.type = V4L2_CTRL_TYPE_INTEGER;
    std::strcpy(reinterpret_cast<char*>(control.name), "A control");
    controls[id] = control;
    values[id] = value;
  }

  /// The sensor delivers a frame of this grey level into the next free buffer. \return  false: all are in use
  bool deliver(const Filled& frame, std::uint8_t level = 100) {
    if (queued.empty()) return false;
    const std::uint32_t index = queued.front();
    queued.erase(queued.begin());
    std::memset(memory[index].data(), level, memory[index].size());
    v4l2_buffer buffer{};
    buffer.index = index;
    buffer.sequence = frame.sequence;
    buffer.flags = frame.flags;
    buffer.bytesused = frame.bytes != 0 ? frame.bytes : static_cast<std::uint32_t>(memory[index].size());
    const std::int64_t us = to_ns(frame.stamp) / 1000;
    buffer.timestamp = {us / 1'000'000, us % 1'000'000};
    filled.push_back(buffer);
    return true;
  }

  int open(const char*) noexcept override {
    if (open_error != 0) return -open_error;
    is_open = true;
    ++opened;
    return kFd;
  }
  void close(int) noexcept override {
    is_open = false;
    queued.clear();
    filled.clear();
  }
  void* map(int, std::size_t, std::uint32_t offset) noexcept override {
    ++mapped;
    return memory[offset].data();
  }
  void unmap(void*, std::size_t) noexcept override { --mapped; }
  int wait(int, MonoTime deadline) noexcept override {
    if (events != 0) return events;
    if (filled.empty()) std::this_thread::sleep_until(deadline);
    return filled.empty() ? 0 : POLLIN;
  }
  int ioctl(int, unsigned long request, void* argument) noexcept override {
    if (const auto refused = refusals.find(request); refused != refusals.end()) return -refused->second;
    return answer(request, argument);
  }

 private:
  template <typename T>
  static T& as(void* argument) {
    return *static_cast<T*>(argument);
  }

  int answer(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        as<v4l2_capability>(argument).capabilities = capabilities;
        std::strcpy(reinterpret_cast<char*>(as<v4l2_capability>(argument).card), card.c_str());
        std::strcpy(reinterpret_cast<char*>(as<v4l2_capability>(argument).bus_info), bus_info.c_str());
        return 0;
      case VIDIOC_G_INPUT:
        as<int>(argument) = 0;
        return 0;
      case VIDIOC_ENUMINPUT:
        as<v4l2_input>(argument).status = input_status;
        return 0;
      case VIDIOC_ENUM_FMT: {
        auto& format = as<v4l2_fmtdesc>(argument);
        if (format.index >= formats.size()) return -EINVAL;
        format.pixelformat = formats[format.index].fourcc;
        return 0;
      }
      case VIDIOC_ENUM_FRAMESIZES:
        return enumerate_size(as<v4l2_frmsizeenum>(argument));
      case VIDIOC_ENUM_FRAMEINTERVALS:
        return enumerate_interval(as<v4l2_frmivalenum>(argument));
      case VIDIOC_S_FMT:
        return set_format(as<v4l2_format>(argument).fmt.pix);
      case VIDIOC_S_PARM:
      case VIDIOC_SUBSCRIBE_EVENT:
        return 0;
      case VIDIOC_REQBUFS:
        as<v4l2_requestbuffers>(argument).count = given_buffers;
        queued.reserve(given_buffers), filled.reserve(given_buffers);
        memory.assign(given_buffers, std::vector<std::uint8_t>(frame_bytes_));
        return 0;
      case VIDIOC_QUERYBUF:
        as<v4l2_buffer>(argument).length = frame_bytes_;
        as<v4l2_buffer>(argument).m.offset = as<v4l2_buffer>(argument).index;
        return 0;
      case VIDIOC_QBUF:
        queued.push_back(as<v4l2_buffer>(argument).index);
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(as<v4l2_buffer>(argument));
      case VIDIOC_STREAMON:
      case VIDIOC_STREAMOFF:
        is_streaming = request == VIDIOC_STREAMON;
        return 0;
      default:
        return control(request, argument);
    }
  }
  int control(unsigned long request, void* argument) {
    if (request == VIDIOC_QUERYCTRL) {
      auto& wanted = as<v4l2_queryctrl>(argument);
      const bool next = (wanted.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
      const std::uint32_t id = wanted.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
      const auto found = next ? controls.upper_bound(id) : controls.find(id);
      if (found == controls.end()) return -EINVAL;
      wanted = found->second;
      return 0;
    }
    if (request == VIDIOC_QUERYMENU)  // like a webcam: manual, and aperture priority as its automatic
      return as<v4l2_querymenu>(argument).index == V4L2_EXPOSURE_AUTO ? -EINVAL : 0;
    if (request != VIDIOC_G_CTRL && request != VIDIOC_S_CTRL) return -ENOTTY;
    auto& value = as<v4l2_control>(argument);
    if (controls.count(value.id) == 0) return -EINVAL;
    if (request == VIDIOC_S_CTRL) {
      written.emplace_back(value.id, value.value);
      values[value.id] = round_control ? round_control(value.value) : value.value;
    }
    value.value = values[value.id];
    return 0;
  }
  const Format* find(std::uint32_t fourcc) const {
    for (const Format& format : formats)
      if (format.fourcc == fourcc) return &format;
    return nullptr;
  }
  int enumerate_size(v4l2_frmsizeenum& size) const {
    const Format* const format = find(size.pixel_format);
    if (format == nullptr || size.index >= format->sizes.size()) return -EINVAL;
    size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    size.discrete = {static_cast<__u32>(format->sizes[size.index][0]),
                     static_cast<__u32>(format->sizes[size.index][1])};
    return 0;
  }
  int enumerate_interval(v4l2_frmivalenum& interval) const {
    const Format* const format = find(interval.pixel_format);
    if (format == nullptr || interval.index > 0) return -EINVAL;
    interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    interval.discrete = {1, format->rate_hz};
    return 0;
  }
  int set_format(v4l2_pix_format& format) {
    format.field = V4L2_FIELD_NONE;
    if (change_format) change_format(format);
    format.bytesperline = stride_bytes;
    const PixelFormat* const known = find_pixel_format(format.pixelformat);
    const auto row = known != nullptr ? row_bytes(*known, static_cast<int>(format.width)) : 0;
    frame_bytes_ = static_cast<std::uint32_t>(std::max<std::size_t>(row, stride_bytes) * format.height);
    const bool is_420 = format.pixelformat == V4L2_PIX_FMT_NV12 || format.pixelformat == V4L2_PIX_FMT_YUV420;
    if (is_420) frame_bytes_ += frame_bytes_ / 2;
    if (frame_bytes_ == 0) frame_bytes_ = 4096;
    return 0;
  }
  int dequeue(v4l2_buffer& buffer) {
    if (dqbuf_error != 0) return -dqbuf_error;
    if (filled.empty()) return -EAGAIN;
    buffer = filled.front();
    filled.erase(filled.begin());
    return 0;
  }

 public:
  std::function<int(int)> round_control;
  std::function<void(v4l2_pix_format&)> change_format;

 private:
  std::uint32_t frame_bytes_ = 0;
};

}  // namespace ninedot
