#pragma once
/// Exposure, gain, flicker and focus of a V4L2 camera: written, then read back; what the driver says then is what
/// counts.
#include <limits>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/sensor_timing.h"
#include "drivers/camera/video_kernel.h"

namespace ninedot {

/// What a camera may change by itself, or another program may.
struct LiveControls {
  std::chrono::nanoseconds exposure{0};                    ///< 0 = the camera does not say
  double zoom = std::numeric_limits<double>::quiet_NaN();  ///< V4L2_CID_ZOOM_ABSOLUTE [the driver's steps]; NaN: none
};

struct AppliedControls {
  LiveControls now;         ///< as read back
  std::string description;  ///< "exposure 5000 us, gain 16"; empty: there was nothing to set
};

/// Sets the controls of `request`. What is left automatic or unchanged may be missing in the camera.
/// \param sensor  of a sensor's own node: exposures count in its lines (V4L2_CID_EXPOSURE), and its gain is the
/// analogue
///                one; nullptr: a camera that is one device
/// Throws CameraRefused: a control that is asked for does not exist or is refused; autofocus is on where there is a
/// calibration.
AppliedControls apply_controls(VideoKernel& kernel, int fd, const CameraRequest& request,
                               const SensorTiming* sensor = nullptr);

/// Reads them; one that the camera does not have costs a call that fails. Blocks as long as the driver does: a USB
/// camera is asked over the bus, and the kernel gives it 5 s (UVC_CTRL_CONTROL_TIMEOUT) to answer.
LiveControls read_live_controls(VideoKernel& kernel, int fd, const SensorTiming* sensor = nullptr) noexcept;

/// "Exposure Time, Absolute: 1 to 5000 step 1, now 156", one line for each control that is not disabled.
std::vector<std::string> describe_controls(VideoKernel& kernel, int fd);

}  // namespace ninedot
