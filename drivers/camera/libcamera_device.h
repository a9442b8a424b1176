#pragma once
/// A camera behind libcamera: the sensors on ribbon cables of small boards, and webcams too.
#include <memory>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/v4l2_list.h"

namespace ninedot {

/// Luma comes from the first plane of R8 (GREY), NV12, NV21 or YUV420 without a copy, or from YUYV or UYVY.
///
/// Buffers are mapped once, and requests are used again and again. libcamera's thread puts each completed request into
/// one slot, where the newest wins; `grab` takes it from there, and a thread of this object queues again what `release`
/// gives back (RequestExchange): neither waits for a lock or allocates. A request that is cancelled while the camera
/// runs, or a camera that disconnects, is a loss.
///
/// exposed_at: SensorTimestamp (start of the exposure of the first row) + half of the ExposureTime that the frame's own
/// metadata name, on CLOCK_MONOTONIC (monotonic_from_sensor_timestamp). Frame::gain is AnalogueGain * DigitalGain,
/// focus_dioptre is LensPosition (1/m where the lens is calibrated), both of the frame's own metadata.
///
/// FrameMetadata that a pipeline left unfilled (the virtual pipeline of 0.4 does; no plane has a byte in it, and the
/// time stamp is not the sensor's) is not believed: then the request's own status and sequence count.
///
/// Only one object of this class may be open in a process: libcamera permits one camera manager. Threads: as each
/// method of CameraDevice says.
class LibcameraDevice final : public CameraDevice {
 public:
  explicit LibcameraDevice(const CameraRequest& request);
  ~LibcameraDevice() override;

  void open() override;
  void close() noexcept override;
  std::string description() const override;
  std::chrono::nanoseconds frame_period() const noexcept override;
  Result<GrabbedFrame> grab(MonoTime deadline) noexcept override;
  void release(std::uint32_t buffer) noexcept override;

 private:
  class Session;
  const CameraRequest request_;
  std::string description_;
  std::chrono::nanoseconds period_{};
  std::unique_ptr<Session> session_;  // while open
};

/// What libcamera sees; not while a LibcameraDevice is open.
std::vector<CameraListing> list_libcamera_cameras();

}  // namespace ninedot
