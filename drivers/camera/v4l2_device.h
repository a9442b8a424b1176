#pragma once
/// A V4L2 camera: memory-mapped buffers, taken without blocking, the newest wins.
///
/// GREY, NV12, NV21 and YU12 are lent in the driver's own buffer; other formats become luma in memory of ours, one
/// picture for each of the driver's buffers. Only the single-planar interface is spoken. Where a sensor behind a media
/// graph makes the pictures, it is set through nodes of its own (media_sensor.h), and found anew at each opening.
#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/exposure_stamp.h"
#include "drivers/camera/media_sensor.h"
#include "drivers/camera/pixel_format.h"
#include "drivers/camera/v4l2_controls.h"
#include "drivers/camera/video_kernel.h"
#include "drivers/picture/picture_file.h"

struct v4l2_buffer;

namespace ninedot {

/// Stamps: the driver's where they are CLOCK_MONOTONIC and plausible, else the instant at which the buffer was taken;
/// the middle of the exposure follows by middle_of_exposure with the exposure time that the camera read back. V4L2 has
/// no exposure time of a single frame: an automatic one is as old as the newest `refresh`.
///
/// Frame::zoom is the camera's position; gain and focus are unknown, as V4L2's are in units of the driver's own.
///
/// Threads: as each method of CameraDevice says.
class V4l2Device final : public CameraDevice {
 public:
  /// One with the caller, one ready, two for the driver to fill. A driver may give more or fewer, two at least.
  static constexpr std::uint32_t kBufferCount = 4;

  /// \param request  device: a node's path, or "sensor:NAME" (media_graph.h)
  explicit V4l2Device(const CameraRequest& request, VideoKernel& kernel = linux_video_kernel(),
                      SystemFolders folders = {});
  ~V4l2Device() override { V4l2Device::close(); }
  V4l2Device(const V4l2Device&) = delete;
  V4l2Device& operator=(const V4l2Device&) = delete;

  void open() override;
  void close() noexcept override;
  std::string description() const override { return description_; }
  std::chrono::nanoseconds frame_period() const noexcept override { return period_; }
  Result<GrabbedFrame> grab(MonoTime deadline) noexcept override;
  void release(std::uint32_t buffer) noexcept override;
  /// Reads exposure and zoom anew, every kRefreshPause where they may change: not where the exposure is manual and
  /// there is no zoom. A sensor's exposure may be changed through its own node by anybody, at any time.
  std::optional<std::chrono::nanoseconds> refresh() noexcept override;

  /// At most so far behind the light, for four questions a second on the camera's bus.
  static constexpr std::chrono::milliseconds kRefreshPause{250};

 private:
  static constexpr std::uint32_t kMaxBuffers = 32;  // VIDEO_MAX_FRAME
  static constexpr std::uint32_t kNoBuffer = 0xFFFFFFFFU;

  struct Taken {  // a buffer of the driver's, or why there is none
    std::uint32_t buffer = kNoBuffer;
    std::uint32_t sequence = 0;
    std::size_t bytes = 0;
    MonoTime exposed_at{};
    std::chrono::nanoseconds exposure{};
  };

  void open_node();
  void agree_on_format();
  void check_bayer() const;
  std::string agree_on_rate();
  AppliedControls set_controls();
  void map_buffers();
  void start_streaming();
  [[noreturn]] void refuse(const std::string& what, int error) const;
  void require(int result, const char* what) const;

  Result<Taken> take() noexcept;
  Result<Taken> take_newest() noexcept;
  MonoTime exposure_of(const v4l2_buffer& buffer, const ShutterTiming& timing, MonoTime now) const noexcept;
  Result<GrabbedFrame> as_luma(const Taken& taken) noexcept;

  const CameraRequest request_;
  VideoKernel& kernel_;
  const SystemFolders folders_;
  std::optional<MediaSensor> sensor_;
  std::string node_;  // where the pictures come out
  int fd_ = -1;
  bool is_streaming_ = false;
  std::string description_;
  std::chrono::nanoseconds period_{};
  ShutterTiming timing() const noexcept {
    return {std::chrono::nanoseconds(exposure_ns_.load(std::memory_order_relaxed)), request_.readout};
  }
  LiveControls read_live() noexcept;
  void note(const LiveControls& now) noexcept;
  // Written by the thread that opens and refreshes, read by `grab`.
  std::atomic<std::int64_t> exposure_ns_{0};
  std::atomic<double> zoom_{};

  const PixelFormat* format_ = nullptr;
  std::size_t stride_bytes_ = 0;
  struct Mapping {
    void* memory = nullptr;
    std::size_t bytes = 0;
  };
  std::array<Mapping, kMaxBuffers> mappings_{};
  std::uint32_t buffer_count_ = 0;
  std::vector<std::uint8_t> pictures_;  // one per buffer; empty where the driver's own is lent
  std::optional<BayerDeveloper> bayer_;
  PictureDecoder jpeg_;

  std::uint32_t skipped_ = 0, flagged_ = 0;  // since the newest frame that was returned
};

}  // namespace ninedot
