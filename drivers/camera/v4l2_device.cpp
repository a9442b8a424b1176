// open() is a list of agreements with the driver, each of which may be refused; grab() empties the driver's queue.
#include "drivers/camera/v4l2_device.h"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/contract.h"
#include "drivers/camera/camera_identity.h"
#include "drivers/camera/control_access.h"
#include "drivers/camera/open_failure.h"
#include "drivers/camera/v4l2_controls.h"
#include "drivers/camera/v4l2_formats.h"

namespace ninedot {
namespace {

v4l2_buffer empty_buffer(std::uint32_t index = 0) noexcept {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

V4l2Device::V4l2Device(const CameraRequest& request, VideoKernel& kernel, SystemFolders folders)
    : request_(request), kernel_(kernel), folders_(std::move(folders)), jpeg_({request.width_px, request.height_px}) {}

void V4l2Device::refuse(const std::string& what, int error) const {
  throw CameraRefused(fmt::format("{}: {}", request_.device, what), error);
}

void V4l2Device::require(int result, const char* what) const {
  if (result >= 0) return;
  if (result == -EBUSY || result == -ENODEV) throw CameraRefused(describe_open_failure(node_, -result), -result);
  if (result == -EPIPE && sensor_)
    refuse(
        fmt::format("{}: the formats along {} don't fit, or one of its links is off: `media-ctl -p -d {}` shows them",
                    what, describe_route(sensor_->route()), sensor_->route().graph.device),
        EPIPE);
  refuse(fmt::format("{} failed: {}", what, std::strerror(-result)), -result);
}

void V4l2Device::open() {
  EXPECTS(fd_ < 0);
  try {
    open_node();
    agree_on_format();
    // A sensor's nodes obey everybody, also while it runs: whoever has the video node's buffers may ask it something.
    if (sensor_) {
      map_buffers();
      sensor_->set_path(*format_, request_.width_px, request_.height_px);
    }
    const std::string rate_remark = agree_on_rate();
    const AppliedControls controls = set_controls();
    note(controls.now);
    if (!sensor_) map_buffers();
    start_streaming();
    // Some sensors look at a value only now that they have power, and cut it to what fits into a frame (imx296.c).
    if (sensor_) note(read_live());
    description_ = fmt::format("{} {}x{}, {:.4g} Hz{}", format_->name, request_.width_px, request_.height_px,
                               1e9 / static_cast<double>(period_.count()), rate_remark);
    if (!controls.description.empty()) add_part(description_, controls.description);
    if (!sensor_) return;
    add_part(description_, describe_route(sensor_->route()));
    if (const std::string shutter = sensor_->describe_shutter(request_.expected_row_time); !shutter.empty())
      add_part(description_, shutter);
  } catch (...) {
    close();
    throw;
  }
}

void V4l2Device::open_node() {
  node_ = request_.device;
  if (node_.starts_with(kSensorPrefix)) {
    sensor_.emplace(kernel_, find_sensor(kernel_, request_.device, folders_), request_.device);
    node_ = sensor_->route().node;
  }
  fd_ = kernel_.open(node_.c_str());
  if (fd_ < 0) throw CameraRefused(describe_open_failure(node_, -fd_), -fd_);
  v4l2_capability capability{};
  if (kernel_.ioctl(fd_, VIDIOC_QUERYCAP, &capability) < 0)
    refuse("is no V4L2 camera; `ninedot cameras` lists those", ENOTTY);
  const std::uint32_t can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0)
    refuse((can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0
               ? "speaks the multi-planar interface only: use camera.source = \"libcamera\""
               : "captures no pictures (metadata or output node); `ninedot cameras` lists those that do",
           ENOTTY);
  if ((can & V4L2_CAP_STREAMING) == 0) refuse("offers no memory-mapped buffers", ENOTTY);
  check_identity(request_.device, v4l2_identity(node_, capability, folders_.video), request_.calibrated_id);
  if (!sensor_ && (can & V4L2_CAP_IO_MC) != 0)
    if (auto route = find_sensor_in_front_of(kernel_, request_.device, folders_))
      sensor_.emplace(kernel_, *std::move(route), request_.device);

  v4l2_input input{};
  int current = 0;
  if (kernel_.ioctl(fd_, VIDIOC_G_INPUT, &current) >= 0) {
    input.index = static_cast<std::uint32_t>(current);
    if (kernel_.ioctl(fd_, VIDIOC_ENUMINPUT, &input) >= 0) {
      if ((input.status & (V4L2_IN_ST_NO_POWER | V4L2_IN_ST_NO_SIGNAL)) != 0)
        refuse("no signal at the camera's input: check cable and power", ENOLINK);
      // The driver would deliver noise, or the last picture over and over.
      if ((input.status & (V4L2_IN_ST_NO_H_LOCK | V4L2_IN_ST_NO_SYNC)) != 0)
        refuse("the signal at the camera's input can't be locked on to: check cable and video mode", ENOLINK);
    }
  }
}

void V4l2Device::agree_on_format() {
  std::vector<OfferedFormat> offers = read_offered_formats(kernel_, fd_);
  if (sensor_) offers = sensor_->offers(offers, request_);
  const std::string offered = fmt::format("{}", fmt::join(describe_offers(offers), "; "));
  const auto refuse_with_offers = [&] {
    refuse(fmt::format("the camera has no {} {}x{}; it offers {}",
                       request_.pixel_format == "auto" ? "readable format at" : request_.pixel_format,
                       request_.width_px, request_.height_px, offered),
           EINVAL);
  };
  const OfferedFormat* const offer = choose_format(offers, request_);
  if (offer == nullptr) refuse_with_offers();
  format_ = offer->known;
  if (format_->layout == PixelLayout::kBayer) check_bayer();

  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<std::uint32_t>(request_.width_px);
  format.fmt.pix.height = static_cast<std::uint32_t>(request_.height_px);
  format.fmt.pix.pixelformat = offer->fourcc;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  require(kernel_.ioctl(fd_, VIDIOC_S_FMT, &format), "setting the format");
  if (format.fmt.pix.pixelformat != offer->fourcc || static_cast<int>(format.fmt.pix.width) != request_.width_px ||
      static_cast<int>(format.fmt.pix.height) != request_.height_px)
    refuse(fmt::format("asked for {} {}x{}, the camera gives {} {}x{}; it offers {}", format_->name, request_.width_px,
                       request_.height_px, fourcc_text(format.fmt.pix.pixelformat), format.fmt.pix.width,
                       format.fmt.pix.height, offered),
           EINVAL);
  if (format.fmt.pix.field != V4L2_FIELD_NONE && format.fmt.pix.field != V4L2_FIELD_ANY)
    refuse("the camera gives interlaced pictures; choose another input or standard", EINVAL);
  // Some drivers leave it zero, meaning rows without gaps.
  stride_bytes_ = std::max<std::size_t>(format.fmt.pix.bytesperline, row_bytes(*format_, request_.width_px));
}

void V4l2Device::check_bayer() const {
  const unsigned largest = (1U << format_->bayer.bits) - 1;
  if (request_.bayer.black_level >= largest)
    refuse(fmt::format("camera.black_level = {} leaves no light: {} goes to {}", request_.bayer.black_level,
                       format_->name, largest),
           EINVAL);
}

/// \return  a remark for people, empty where there is none
std::string V4l2Device::agree_on_rate() {
  if (sensor_) {
    const std::string remark = sensor_->set_rate(request_.rate_hz);
    period_ = sensor_->period().value_or(std::chrono::nanoseconds(std::llround(1e9 / request_.rate_hz)));
    return remark;
  }
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  parameters.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(request_.rate_hz * 1000))};
  // Capture cards and some sensors have one rate; what they read back is what counts.
  if (kernel_.ioctl(fd_, VIDIOC_S_PARM, &parameters) < 0) kernel_.ioctl(fd_, VIDIOC_G_PARM, &parameters);
  const v4l2_fract& period = parameters.parm.capture.timeperframe;
  const double period_s = period.numerator > 0 && period.denominator > 0
                              ? static_cast<double>(period.numerator) / period.denominator
                              : 1 / request_.rate_hz;
  period_ = std::chrono::nanoseconds(std::llround(period_s * 1e9));
  return {};
}

AppliedControls V4l2Device::set_controls() {
  return sensor_ ? apply_controls(kernel_, sensor_->fd(), request_, &sensor_->timing())
                 : apply_controls(kernel_, fd_, request_);
}

void V4l2Device::map_buffers() {
  v4l2_requestbuffers wanted{};
  wanted.count = kBufferCount;
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.memory = V4L2_MEMORY_MMAP;
  require(kernel_.ioctl(fd_, VIDIOC_REQBUFS, &wanted), "asking for buffers");
  if (wanted.count < 2 || wanted.count > kMaxBuffers)
    refuse(fmt::format("the driver gives {} buffers, at least 2 are needed", wanted.count), ENOMEM);
  const auto rows = static_cast<std::size_t>(request_.height_px);
  const std::size_t needed = stride_bytes_ * (rows - 1) + row_bytes(*format_, request_.width_px);
  for (std::uint32_t i = 0; i < wanted.count; ++i) {
    v4l2_buffer buffer = empty_buffer(i);
    require(kernel_.ioctl(fd_, VIDIOC_QUERYBUF, &buffer), "asking where a buffer is");
    if (format_->layout != PixelLayout::kJpeg && buffer.length < needed)
      refuse(fmt::format("the driver's buffers are too small: {} bytes, {} needed", buffer.length, needed), EINVAL);
    void* const memory = kernel_.map(fd_, buffer.length, buffer.m.offset);
    if (memory == nullptr) refuse("a buffer can't be mapped into memory", ENOMEM);
    mappings_[i] = {memory, buffer.length};
    buffer_count_ = i + 1;
  }
  const std::size_t picture = rows * static_cast<std::size_t>(request_.width_px);
  bayer_.reset();
  if (format_->layout == PixelLayout::kBayer) {
    bayer_.emplace(format_->bayer, request_.bayer, request_.width_px, request_.height_px);
    pictures_.resize(bayer_->picture_bytes() * buffer_count_);
  } else {
    pictures_.resize(format_->layout == PixelLayout::kLumaPlane ? 0 : picture * buffer_count_);
  }
}

void V4l2Device::start_streaming() {
  // A capture card tells in this way that its signal came, went or changed; others refuse, which is fine.
  v4l2_event_subscription change{};
  change.type = V4L2_EVENT_SOURCE_CHANGE;
  kernel_.ioctl(fd_, VIDIOC_SUBSCRIBE_EVENT, &change);
  for (std::uint32_t i = 0; i < buffer_count_; ++i) {
    v4l2_buffer buffer = empty_buffer(i);
    require(kernel_.ioctl(fd_, VIDIOC_QBUF, &buffer), "handing over a buffer");
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  require(kernel_.ioctl(fd_, VIDIOC_STREAMON, &type), "starting the stream");
  is_streaming_ = true;
}

void V4l2Device::close() noexcept {
  sensor_.reset();
  if (fd_ < 0) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (is_streaming_) kernel_.ioctl(fd_, VIDIOC_STREAMOFF, &type);
  is_streaming_ = false;
  for (std::uint32_t i = 0; i < buffer_count_; ++i) kernel_.unmap(mappings_[i].memory, mappings_[i].bytes);
  buffer_count_ = 0;
  kernel_.close(fd_);
  fd_ = -1;
}

Result<GrabbedFrame> V4l2Device::grab(MonoTime deadline) noexcept {
  EXPECTS(fd_ >= 0);
  for (;;) {
    const Result<Taken> taken = take_newest();
    if (taken) return as_luma(*taken);
    if (taken.error().code != Errc::kNoFrame) return tl::unexpected<Error>(taken.error());
    const int events = kernel_.wait(fd_, deadline);
    if (events < 0) return fail(Errc::kCameraLost, "waiting for the camera failed", -events);
    if (events == 0) return fail(Errc::kNoFrame, "no frame in time");
    if ((events & POLLPRI) != 0) return fail(Errc::kCameraLost, "the signal at the camera's input changed", ENOLINK);
    if ((events & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
      // The driver says why at the next buffer; POLLERR without a reason is a stream that stopped.
      const Result<Taken> last = take();
      if (!last && last.error().code != Errc::kNoFrame) return tl::unexpected<Error>(last.error());
      return fail(Errc::kCameraLost, "the camera stopped", ENODEV);
    }
  }
}

/// Empties the driver's queue and keeps the last good buffer.
Result<V4l2Device::Taken> V4l2Device::take_newest() noexcept {
  Taken newest;
  // Bounded: each buffer once, whatever the driver refills meanwhile.
  for (std::uint32_t i = 0; i < buffer_count_; ++i) {
    const Result<Taken> taken = take();
    if (!taken) {
      if (taken.error().code == Errc::kNoFrame) break;
      return taken;  // a lost device: closing it takes back what is in hand
    }
    if (taken->buffer == kNoBuffer) continue;
    if (newest.buffer != kNoBuffer) {
      release(newest.buffer);
      ++skipped_;
    }
    newest = *taken;
  }
  if (newest.buffer == kNoBuffer) return fail(Errc::kNoFrame, "no frame in time");
  return newest;
}

/// One buffer out of the driver's queue. buffer == kNoBuffer: it was damaged and is given back.
Result<V4l2Device::Taken> V4l2Device::take() noexcept {
  v4l2_buffer buffer = empty_buffer();
  const int result = kernel_.ioctl(fd_, VIDIOC_DQBUF, &buffer);
  if (result == -EAGAIN) return fail(Errc::kNoFrame, "no frame in time");
  if (result < 0 || buffer.index >= buffer_count_)
    return fail(Errc::kCameraLost, result == -ENODEV ? "the camera is gone" : "taking a frame failed", -result);
  const std::size_t needed =
      format_->layout == PixelLayout::kJpeg
          ? 1
          : stride_bytes_ * static_cast<std::size_t>(request_.height_px - 1) + row_bytes(*format_, request_.width_px);
  const ShutterTiming timing = this->timing();
  Taken taken{buffer.index, buffer.sequence, std::min<std::size_t>(buffer.bytesused, mappings_[buffer.index].bytes),
              exposure_of(buffer, timing, mono_now()), timing.exposure};
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && taken.bytes >= needed) return taken;
  release(buffer.index);
  ++flagged_;
  taken.buffer = kNoBuffer;
  return taken;
}

MonoTime V4l2Device::exposure_of(const v4l2_buffer& buffer, const ShutterTiming& timing, MonoTime now) const noexcept {
  const MonoTime stamp =
      stamp_of(std::chrono::seconds(buffer.timestamp.tv_sec), std::chrono::microseconds(buffer.timestamp.tv_usec));
  const bool is_monotonic = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  if (!is_monotonic || !is_plausible_stamp(stamp, now)) return middle_of_exposure(now, StampPoint::kEndOfFrame, timing);
  const bool is_start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return middle_of_exposure(stamp, is_start ? StampPoint::kStartOfExposure : StampPoint::kEndOfFrame, timing);
}

Result<GrabbedFrame> V4l2Device::as_luma(const Taken& taken) noexcept {
  GrabbedFrame grabbed;
  Frame& frame = grabbed.frame;
  grabbed.buffer = taken.buffer;
  grabbed.sequence = taken.sequence;
  frame.set_exposure(taken.exposed_at, taken.exposure);
  frame.row_time = request_.row_time;
  frame.zoom = zoom_.load(std::memory_order_relaxed);
  const auto* const pixels = static_cast<const std::uint8_t*>(mappings_[taken.buffer].memory);
  const int width = request_.width_px, height = request_.height_px;
  frame.luma = {pixels, width, height, static_cast<std::ptrdiff_t>(stride_bytes_)};
  frame.chroma = chroma_of(*format_, pixels, stride_bytes_, width, height, taken.bytes);
  if (bayer_) {
    std::uint8_t* const picture = pictures_.data() + taken.buffer * bayer_->picture_bytes();
    bayer_->develop(pixels, stride_bytes_, picture);
    frame.luma = {picture, width, height, width};
    frame.chroma = bayer_->chroma_of(picture);
  } else if (format_->layout != PixelLayout::kLumaPlane) {
    const std::size_t picture = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    std::uint8_t* const luma = pictures_.data() + taken.buffer * picture;
    if (format_->layout == PixelLayout::kJpeg) {
      if (const auto size = jpeg_.decode({pixels, taken.bytes}, {luma, picture}); !size) {
        release(taken.buffer);
        return fail(Errc::kFrameUnreadable, size.error().text);
      }
    } else {
      convert_to_luma(*format_, pixels, stride_bytes_, width, height, luma);
    }
    frame.luma = {luma, width, height, width};
  }
  grabbed.skipped = std::exchange(skipped_, 0);
  grabbed.flagged = std::exchange(flagged_, 0);
  return grabbed;
}

LiveControls V4l2Device::read_live() noexcept {
  return sensor_ ? read_live_controls(kernel_, sensor_->fd(), &sensor_->timing()) : read_live_controls(kernel_, fd_);
}

void V4l2Device::note(const LiveControls& now) noexcept {
  exposure_ns_.store(now.exposure.count(), std::memory_order_relaxed);
  zoom_.store(now.zoom, std::memory_order_relaxed);
}

std::optional<std::chrono::nanoseconds> V4l2Device::refresh() noexcept {
  EXPECTS(fd_ >= 0);
  LiveControls now = read_live();
  // A camera that just does not answer keeps what was known.
  if (now.exposure.count() == 0) now.exposure = timing().exposure;
  if (std::isnan(now.zoom)) now.zoom = zoom_.load(std::memory_order_relaxed);
  note(now);
  const bool is_automatic = now.exposure.count() > 0 && (request_.exposure.count() == 0 || sensor_);
  if (!is_automatic && std::isnan(now.zoom)) return std::nullopt;
  return kRefreshPause;
}

void V4l2Device::release(std::uint32_t index) noexcept {
  v4l2_buffer buffer = empty_buffer(index);
  // A refusal means a device that is gone or stopped: the next DQBUF says so.
  kernel_.ioctl(fd_, VIDIOC_QBUF, &buffer);
}

}  // namespace ninedot
