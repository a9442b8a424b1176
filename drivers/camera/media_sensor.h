#pragma once
/// A sensor behind a media graph: the part of such a camera that its video node does not have.
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/media_graph.h"
#include "drivers/camera/pixel_format.h"
#include "drivers/camera/sensor_timing.h"
#include "drivers/camera/v4l2_formats.h"

namespace ninedot {

/// Its node is open as long as this lives. Everything is set anew by each MediaSensor: another program may have changed
/// it, and a sensor that was without power has forgotten it. Throws CameraRefused, in the name of `device`.
/// Threads: the one that opens the camera.
class MediaSensor {
 public:
  MediaSensor(VideoKernel& kernel, SensorRoute route, std::string device);
  ~MediaSensor();
  MediaSensor(const MediaSensor&) = delete;
  MediaSensor& operator=(const MediaSensor&) = delete;

  const SensorRoute& route() const noexcept { return route_; }
  int fd() const noexcept { return fd_; }
  /// As it was when the rate was set; not known before, and where the sensor does not tell.
  const SensorTiming& timing() const noexcept { return timing_; }

  /// What comes out of the video node with this sensor in front of it: of the node's formats those that carry one of
  /// the sensor's own, in the sensor's sizes. \param request  a size of its own that the sensor can crop to is one of
  /// them
  std::vector<OfferedFormat> offers(const std::vector<OfferedFormat>& of_node, const CameraRequest& request) const;

  /// Links, crop, and formats from the sensor down to the video node, each read back.
  void set_path(const PixelFormat& format, int width_px, int height_px);

  /// Blanking, so that frames come at this rate or the nearest that the sensor has at the size that was set.
  /// \return  "" or a remark for people: what was asked for, where it is another one
  std::string set_rate(double rate_hz);
  /// Of the rate that was set. Nothing: the sensor does not tell.
  std::optional<std::chrono::nanoseconds> period() const noexcept { return period_; }

  /// What the sensor's blanking is now; nothing is set. \param width, height  of its pictures [px]
  SensorTiming read_timing(int width, int height) const;
  /// The sensor's present size, and its least and largest rate there: "Y8 1280x800, 2.5 to 143.7 Hz, line time 7.65
  /// us".
  std::string describe_now() const;

  /// "line time 7.65 us", and what speaks against this `camera.row_time_us`. Empty: the sensor does not tell.
  std::string describe_shutter(std::chrono::nanoseconds row_time) const;

 private:
  struct Frame {
    std::uint32_t code = 0;  // MEDIA_BUS_FMT_...
    int width_px = 0, height_px = 0;
  };
  [[noreturn]] void refuse(const std::string& what, int error) const;
  std::vector<std::uint32_t> codes() const;
  std::vector<OfferedSize> sizes(std::uint32_t code) const;
  bool can_crop_to(int width_px, int height_px) const;
  void crop_for(std::uint32_t code, int width_px, int height_px);
  void set_pad(int fd, std::uint32_t entity_id, std::uint32_t pad_index, const Frame& frame) const;
  void match_neighbours(const Frame& frame) const;
  int line_width_px(int width_px) const;
  std::string set_interval(double rate_hz);

  VideoKernel& kernel_;
  const SensorRoute route_;
  const std::string device_;
  int fd_ = -1;
  int width_px_ = 0, height_px_ = 0;  // of set_path
  SensorTiming timing_;
  std::optional<std::chrono::nanoseconds> period_;
};

/// The media bus code in which a sensor sends this pixel format. \return  0: none does
std::uint32_t bus_code_of(const PixelFormat& format) noexcept;

}  // namespace ninedot
