// One Session is one opening: its destructor gives everything back in the order that libcamera asks for.
#include "drivers/camera/libcamera_device.h"

#include <fmt/format.h>
#include <libcamera/libcamera.h>
#include <linux/dma-buf.h>
#include <pthread.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "base/contract.h"
#include "drivers/camera/camera_identity.h"
#include "drivers/camera/exposure_stamp.h"
#include "drivers/camera/libcamera_shim.h"
#include "drivers/camera/pixel_format.h"
#include "drivers/camera/request_exchange.h"

namespace ninedot {
namespace {

/// One with the caller, one ready, two for the camera to fill.
constexpr unsigned kBufferCount = 4;

/// libcamera's names of the formats that we read, in order of preference.
struct ReadableFormat {
  libcamera::PixelFormat libcamera;
  std::string_view ours;
};
const ReadableFormat kReadable[] = {
    {libcamera::formats::R8, "GREY"},   {libcamera::formats::NV12, "NV12"}, {libcamera::formats::YUV420, "YU12"},
    {libcamera::formats::NV21, "NV21"}, {libcamera::formats::YUYV, "YUYV"}, {libcamera::formats::UYVY, "UYVY"},
};

/// Signals are for the main thread; libcamera's threads inherit the mask of the one that starts them.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_;
};

std::unique_ptr<libcamera::CameraManager> start_manager(const std::string& device) {
  const BlockedSignals blocked;
  // Its log is chatty; who wants it sets the variable, which libcamera reads at its first use. logSetLevel would miss
  // the categories that come to life later. A machine without dma-buf heaps is no error of a user's; of two patterns
  // for one category some versions take the first, others the last.
  [[maybe_unused]] static const int quiet =
      ::setenv("LIBCAMERA_LOG_LEVELS", "DmaBufAllocator:FATAL,*:ERROR,DmaBufAllocator:FATAL", 0);
  auto manager = std::make_unique<libcamera::CameraManager>();
  if (const int error = manager->start(); error < 0)
    throw CameraRefused(fmt::format("{}: libcamera does not start: {}", device, std::strerror(-error)), -error);
  return manager;
}

std::string model_of(const libcamera::Camera& camera) {
  return std::string(camera.properties().get(libcamera::properties::Model).value_or(""));
}

std::string describe_sizes(const libcamera::StreamFormats& formats, const libcamera::PixelFormat& format) {
  std::string text;
  for (const libcamera::Size& size : formats.sizes(format))
    text += fmt::format("{}{}x{}", text.empty() ? "" : ", ", size.width, size.height);
  return text;
}

std::vector<std::string> describe_formats(const libcamera::StreamFormats& formats) {
  std::vector<std::string> lines;
  for (const libcamera::PixelFormat& format : formats.pixelformats()) {
    const auto* const known = std::ranges::find(kReadable, format, &ReadableFormat::libcamera);
    lines.push_back(known != std::end(kReadable)
                        ? fmt::format("{} {}", known->ours, describe_sizes(formats, format))
                        : fmt::format("{} {} (not readable here)", format.toString(), describe_sizes(formats, format)));
  }
  return lines;
}

std::shared_ptr<libcamera::Camera> find_camera(libcamera::CameraManager& manager, const std::string& device) {
  std::vector<std::shared_ptr<libcamera::Camera>> same_model;
  std::string all;
  for (const std::shared_ptr<libcamera::Camera>& camera : manager.cameras()) {
    if (camera->id() == device) return camera;
    if (model_of(*camera) == device) same_model.push_back(camera);
    all += fmt::format("{}{} ({})", all.empty() ? "" : ", ", camera->id(), model_of(*camera));
  }
  if (same_model.size() == 1) return same_model.front();
  if (same_model.size() > 1)
    throw CameraRefused(
        fmt::format("{}: there are {} of this model; write the id of one: {}", device, same_model.size(), all), EINVAL);
  throw CameraRefused(
      fmt::format("{}: libcamera has no such camera; {}", device,
                  all.empty() ? "it sees none: check cable, device-tree overlay and membership in the group 'video'"
                              : "it has " + all),
      ENODEV);
}

}  // namespace

class LibcameraDevice::Session {
 public:
  explicit Session(const CameraRequest& request) : request_(request) {
    try {
      manager_ = start_manager(request.device);
      camera_ = find_camera(*manager_, request.device);
      if (const int error = camera_->acquire(); error < 0)
        refuse(error == -EBUSY ? "busy: stop the program that uses it" : "can't be taken", error);
      is_acquired_ = true;
      check_identity(request.device, libcamera_identity(camera_->id()), request.calibrated_id);
      agree_on_format();
      map_buffers();
      start();
    } catch (...) {
      end();
      throw;
    }
  }
  ~Session() { end(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  std::string description() const {
    return fmt::format(
        "{} ({}), {} {}x{}, {:.4g} Hz{}{}{}", camera_->id(), model_of(*camera_), format_->name, request_.width_px,
        request_.height_px, 1e9 / static_cast<double>(period().count()),
        request_.exposure.count() > 0
            ? fmt::format(", exposure {:g} us", std::chrono::duration<double, std::micro>(request_.exposure).count())
            : ", exposure automatic",
        request_.gain > 0 ? fmt::format(", gain {:g}", request_.gain) : "",
        request_.focus == Focus::kFixed       ? fmt::format(", focus {:g} 1/m", request_.focus_position)
        : request_.focus == Focus::kAutomatic ? ", focus automatic"
                                              : "");
  }
  std::chrono::nanoseconds period() const noexcept { return period_; }

  Result<GrabbedFrame> grab(MonoTime deadline) noexcept {
    NINEDOT_TRY(const NewestWins::Taken taken, exchange_->take(deadline));
    libcamera::Request& request = *requests_[taken.buffer];
    GrabbedFrame grabbed;
    Frame& frame = grabbed.frame;
    grabbed.buffer = taken.buffer;
    grabbed.skipped = taken.unseen.skipped;
    grabbed.flagged = taken.unseen.flagged;
    const libcamera::FrameMetadata& metadata = request.findBuffer(stream_)->metadata();
    grabbed.sequence = is_filled_in(request) ? metadata.sequence : request.sequence();
    note_metadata(request, frame);
    synchronise(grabbed.buffer, DMA_BUF_SYNC_START);
    frame.luma = luma_of(grabbed.buffer);
    const Mapping& mapping = mappings_[grabbed.buffer];
    frame.chroma = chroma_of(*format_, static_cast<const std::uint8_t*>(mapping.memory) + mapping.offset, stride_bytes_,
                             request_.width_px, request_.height_px, mapping.bytes - mapping.offset);
    return grabbed;
  }

  void release(std::uint32_t buffer) noexcept {
    synchronise(buffer, DMA_BUF_SYNC_END);
    exchange_->give_back(buffer);
  }

 private:
  struct Mapping {
    void* memory = MAP_FAILED;
    std::size_t bytes = 0;
    std::size_t offset = 0;  // of the luma plane
    int fd = -1;
  };

  [[noreturn]] void refuse(const std::string& what, int error) const {
    throw CameraRefused(fmt::format("{}: {}{}", request_.device, what,
                                    error == 0 || error == -EBUSY ? "" : fmt::format(": {}", std::strerror(-error))),
                        -error);
  }

  void agree_on_format() {
    configuration_ = camera_->generateConfiguration({libcamera::StreamRole::Viewfinder});
    if (configuration_ == nullptr || configuration_->empty()) refuse("the camera offers no stream of pictures", 0);
    libcamera::StreamConfiguration& stream = configuration_->at(0);
    const std::string offers = fmt::format("{}", fmt::join(describe_formats(stream.formats()), "; "));
    for (const ReadableFormat& readable : kReadable) {
      if (request_.pixel_format != "auto" && request_.pixel_format != readable.ours) continue;
      stream.pixelFormat = readable.libcamera;
      stream.size = {static_cast<unsigned>(request_.width_px), static_cast<unsigned>(request_.height_px)};
      stream.bufferCount = kBufferCount;
      stream.stride = 0;
      if (configuration_->validate() == libcamera::CameraConfiguration::Invalid) continue;
      if (stream.pixelFormat != readable.libcamera || static_cast<int>(stream.size.width) != request_.width_px ||
          static_cast<int>(stream.size.height) != request_.height_px)
        continue;
      format_ = find_pixel_format(readable.ours);
      if (const int error = camera_->configure(configuration_.get()); error < 0)
        refuse("the camera refused its own configuration", error);
      stride_bytes_ = std::max<std::size_t>(stream.stride, row_bytes(*format_, request_.width_px));
      stream_ = stream.stream();
      return;
    }
    refuse(fmt::format("the camera has no {} {}x{}; it offers {}",
                       request_.pixel_format == "auto" ? "readable format at" : request_.pixel_format,
                       request_.width_px, request_.height_px, offers),
           0);
  }

  void map_buffers() {
    allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
    if (const int error = allocator_->allocate(stream_); error < 0) refuse("no memory for pictures", error);
    const std::size_t needed =
        stride_bytes_ * static_cast<std::size_t>(request_.height_px - 1) + row_bytes(*format_, request_.width_px);
    for (const std::unique_ptr<libcamera::FrameBuffer>& buffer : allocator_->buffers(stream_)) {
      const libcamera::FrameBuffer::Plane& plane = buffer->planes().front();
      Mapping mapping;
      mapping.offset = plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
      mapping.bytes = mapping.offset + plane.length;
      // Planes that lie together in one buffer are mapped together, for their colour.
      const bool is_gapless = plane.length == stride_bytes_ * static_cast<std::size_t>(request_.height_px);
      for (const libcamera::FrameBuffer::Plane& other : buffer->planes())
        if (is_gapless && other.fd.get() == plane.fd.get() && other.offset == mapping.bytes)
          mapping.bytes += other.length;
      mapping.fd = plane.fd.get();
      mapping.memory = ::mmap(nullptr, mapping.bytes, PROT_READ, MAP_SHARED, mapping.fd, 0);
      if (mapping.memory == MAP_FAILED) refuse("a buffer can't be mapped into memory", -errno);
      mappings_.push_back(mapping);
      if (plane.length < needed)
        refuse(fmt::format("the camera's buffers are too small: {} bytes, {} needed", plane.length, needed), 0);
      auto request = camera_->createRequest(requests_.size());
      if (request == nullptr || request->addBuffer(stream_, buffer.get()) < 0)
        refuse("requests can't be made", -ENOMEM);
      requests_.push_back(std::move(request));
    }
    if (requests_.size() < 2) refuse("the camera gives fewer than 2 buffers", 0);
    if (requests_.size() > NewestWins::kCapacity) refuse("the camera gives more than 32 buffers", 0);
    if (format_->layout != PixelLayout::kLumaPlane) luma_.resize(picture_bytes() * requests_.size());
  }

  void start() {
    const libcamera::ControlInfoMap& known = camera_->controls();
    if (request_.exposure.count() > 0 && !shim::has_exposure(known))
      refuse("the camera has no control for the exposure time; remove camera.exposure_us", 0);
    if (request_.gain > 0 && !shim::has_gain(known))
      refuse("the camera has no control for the gain; remove camera.gain", 0);
    libcamera::ControlList controls(libcamera::controls::controls);
    shim::set_exposure_and_gain(controls, known,
                                std::chrono::duration_cast<std::chrono::microseconds>(request_.exposure),
                                static_cast<float>(request_.gain));
    set_focus(controls, known);
    set_frame_duration(controls, known);
    exchange_.emplace([this](std::uint32_t request) { queue_again(*requests_[request]); });
    camera_->requestCompleted.connect(this, &Session::on_completed);
    camera_->disconnected.connect(this, &Session::on_disconnected);
    const BlockedSignals blocked;
    if (const int error = camera_->start(&controls); error < 0) refuse("starting the stream failed", error);
    is_running_ = true;
    for (const std::unique_ptr<libcamera::Request>& request : requests_)
      if (const int error = camera_->queueRequest(request.get()); error < 0) refuse("a request was refused", error);
  }

  void set_focus(libcamera::ControlList& controls, const libcamera::ControlInfoMap& known) {
    const bool can_focus = shim::has_autofocus(known);
    const std::optional<shim::FocusRange> range = shim::focus_range(known);
    if (request_.focus == Focus::kUnchanged && !can_focus) return;
    if (request_.focus != Focus::kFixed && can_focus && request_.is_calibrated)
      refuse(fmt::format(
                 "its lens may focus by itself, and a calibration holds for one focus only: set camera.focus = "
                 "\"fixed\"{}",
                 range ? fmt::format(" and camera.focus_position, from {:g} to {:g} (1/m), that of the calibration",
                                     range->least_per_m, range->most_per_m)
                       : ""),
             0);
    if (request_.focus == Focus::kUnchanged) return;
    if (!can_focus && (!range || request_.focus == Focus::kAutomatic))
      refuse("the camera has no control for the focus; remove camera.focus", 0);
    const bool is_fixed = request_.focus == Focus::kFixed;
    if (is_fixed && range &&
        !(request_.focus_position >= range->least_per_m && request_.focus_position <= range->most_per_m))
      refuse(fmt::format("set camera.focus_position, from {:g} to {:g} (1/m)", range->least_per_m, range->most_per_m),
             0);
    shim::set_focus(controls, known,
                    is_fixed && range ? std::optional(static_cast<float>(request_.focus_position)) : std::nullopt,
                    is_fixed);
  }

  void set_frame_duration(libcamera::ControlList& controls, const libcamera::ControlInfoMap& known) {
    std::int64_t shortest_us = std::llround(1e6 / request_.rate_hz);
    std::int64_t longest_us = shortest_us;
    if (const auto limits = known.find(&libcamera::controls::FrameDurationLimits); limits != known.end()) {
      const auto least = limits->second.min().get<std::int64_t>();
      const auto most = limits->second.max().get<std::int64_t>();
      if (least > 0 && most >= least) {
        shortest_us = std::clamp(shortest_us, least, most);
        longest_us = request_.lower_rate_in_the_dark ? most : shortest_us;
      }
      const std::int64_t both_us[2] = {shortest_us, longest_us};
      controls.set(libcamera::controls::FrameDurationLimits, libcamera::Span<const std::int64_t, 2>(both_us));
    }
    period_ = std::chrono::microseconds(shortest_us);
  }

  void end() noexcept {
    if (camera_ != nullptr) {
      is_ending_.store(true, std::memory_order_release);
      if (exchange_) exchange_->stop();  // a camera that is being stopped takes no requests
      if (is_running_) camera_->stop();
      camera_->requestCompleted.disconnect(this);
      camera_->disconnected.disconnect(this);
    }
    requests_.clear();
    for (const Mapping& mapping : mappings_) ::munmap(mapping.memory, mapping.bytes);
    mappings_.clear();
    allocator_.reset();
    configuration_.reset();
    if (is_acquired_) camera_->release();
    camera_.reset();
    if (manager_ != nullptr) manager_->stop();
    manager_.reset();
  }

  // libcamera's thread from here ...
  void on_completed(libcamera::Request* request) {
    if (is_ending_.load(std::memory_order_acquire)) return;
    const auto number = static_cast<std::uint32_t>(request->cookie());
    if (request->status() == libcamera::Request::RequestCancelled)
      exchange_->lose("the camera cancelled a request");
    else if (is_damaged(*request))
      exchange_->complete_damaged(number);
    else
      exchange_->complete(number);
  }
  void on_disconnected() { exchange_->lose("the camera is gone"); }
  // ... to here.

  bool is_filled_in(libcamera::Request& request) const {
    const libcamera::FrameMetadata& metadata = request.findBuffer(stream_)->metadata();
    const auto stamp = request.metadata().get(libcamera::controls::SensorTimestamp);
    const bool has_bytes = std::ranges::any_of(
        metadata.planes(), [](const libcamera::FrameMetadata::Plane& plane) { return plane.bytesused > 0; });
    return has_bytes || (stamp && metadata.timestamp == static_cast<std::uint64_t>(*stamp));
  }
  bool is_damaged(libcamera::Request& request) const {
    return is_filled_in(request) &&
           request.findBuffer(stream_)->metadata().status != libcamera::FrameMetadata::FrameSuccess;
  }
  /// On the thread of exchange_: libcamera allocates for this.
  void queue_again(libcamera::Request& request) noexcept {
    request.reuse(libcamera::Request::ReuseBuffers);
    // A refusal means a camera that is gone: it says so itself, or stalls.
    camera_->queueRequest(&request);
  }

  void note_metadata(libcamera::Request& request, Frame& frame) const noexcept {
    const MonoTime now = mono_now();
    const auto exposure_us = request.metadata().get(libcamera::controls::ExposureTime);
    const ShutterTiming timing{
        exposure_us ? std::chrono::nanoseconds(std::chrono::microseconds(*exposure_us)) : request_.exposure,
        request_.readout};
    const auto stamp = request.metadata().get(libcamera::controls::SensorTimestamp);
    const auto gain = request.metadata().get(libcamera::controls::AnalogueGain);
    const auto digital_gain = request.metadata().get(libcamera::controls::DigitalGain);
    if (gain) frame.gain = static_cast<double>(*gain) * static_cast<double>(digital_gain.value_or(1.0F));
    const auto lens = request.metadata().get(libcamera::controls::LensPosition);
    if (lens) frame.focus_dioptre = static_cast<double>(*lens);
    frame.row_time = request_.row_time;
    frame.set_exposure(stamp ? middle_of_exposure(monotonic_from_sensor_timestamp(std::chrono::nanoseconds(*stamp),
                                                                                  read_suspended_time(), now),
                                                  StampPoint::kStartOfExposure, timing)
                             : middle_of_exposure(now, StampPoint::kEndOfFrame, timing),
                       timing.exposure);
  }

  /// Caches of the CPU against what the camera wrote; memory that needs none refuses the call.
  void synchronise(std::uint32_t buffer, std::uint64_t phase) const noexcept {
    dma_buf_sync sync{phase | DMA_BUF_SYNC_READ};
    while (::ioctl(mappings_[buffer].fd, DMA_BUF_IOCTL_SYNC, &sync) < 0 && (errno == EINTR || errno == EAGAIN)) {
    }
  }

  std::size_t picture_bytes() const noexcept {
    return static_cast<std::size_t>(request_.width_px) * static_cast<std::size_t>(request_.height_px);
  }
  ImageView luma_of(std::uint32_t buffer) noexcept {
    const Mapping& mapping = mappings_[buffer];
    const auto* const pixels = static_cast<const std::uint8_t*>(mapping.memory) + mapping.offset;
    const int width = request_.width_px, height = request_.height_px;
    if (format_->layout == PixelLayout::kLumaPlane)
      return {pixels, width, height, static_cast<std::ptrdiff_t>(stride_bytes_)};
    std::uint8_t* const luma = luma_.data() + buffer * picture_bytes();
    convert_to_luma(*format_, pixels, stride_bytes_, width, height, luma);
    return {luma, width, height, width};
  }

  const CameraRequest& request_;
  std::unique_ptr<libcamera::CameraManager> manager_;
  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  libcamera::Stream* stream_ = nullptr;
  const PixelFormat* format_ = nullptr;
  std::size_t stride_bytes_ = 0;
  std::chrono::nanoseconds period_{};
  std::vector<Mapping> mappings_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;  // the cookie is the place
  std::vector<std::uint8_t> luma_;
  bool is_acquired_ = false, is_running_ = false;

  std::atomic<bool> is_ending_{false};
  std::optional<RequestExchange> exchange_;  // from the start on
};

LibcameraDevice::LibcameraDevice(const CameraRequest& request) : request_(request) {}
LibcameraDevice::~LibcameraDevice() = default;

void LibcameraDevice::open() {
  EXPECTS(session_ == nullptr);
  session_ = std::make_unique<Session>(request_);
  description_ = session_->description();
  period_ = session_->period();
}

void LibcameraDevice::close() noexcept { session_.reset(); }
std::string LibcameraDevice::description() const { return description_; }
std::chrono::nanoseconds LibcameraDevice::frame_period() const noexcept { return period_; }

Result<GrabbedFrame> LibcameraDevice::grab(MonoTime deadline) noexcept {
  EXPECTS(session_ != nullptr);
  return session_->grab(deadline);
}

void LibcameraDevice::release(std::uint32_t buffer) noexcept { session_->release(buffer); }

std::vector<CameraListing> list_libcamera_cameras() {
  const auto manager = start_manager("libcamera");
  std::vector<CameraListing> cameras;
  for (const std::shared_ptr<libcamera::Camera>& camera : manager->cameras()) {
    CameraListing listing;
    listing.device = camera->id();
    listing.name = model_of(*camera);
    listing.identity = libcamera_identity(camera->id());
    if (const auto configuration = camera->generateConfiguration({libcamera::StreamRole::Viewfinder});
        configuration != nullptr && !configuration->empty())
      listing.formats = describe_formats(configuration->at(0).formats());
    for (const auto& [id, range] : camera->controls())
      listing.controls.push_back(fmt::format("{}: {}", id->name(), range.toString()));
    cameras.push_back(std::move(listing));
  }
  manager->stop();
  return cameras;
}

}  // namespace ninedot
