#pragma once
/// Exposure, gain and flicker of a V4L2 camera: written, then read back; what the driver says then is what counts.
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/video_kernel.h"

namespace ninedot {

struct AppliedControls {
  std::chrono::nanoseconds exposure{0};  ///< as read back; 0 = the camera does not say
  std::string description;               ///< "exposure 5000 us, gain 16"; empty: there was nothing to set
};

/// Sets the controls of `request`. What is left automatic or unchanged may be missing in the camera.
/// Throws CameraRefused: a control that is asked for does not exist or is refused.
AppliedControls apply_controls(VideoKernel& kernel, int fd, const CameraRequest& request);

/// "Exposure Time, Absolute: 1 to 5000 step 1, now 156", one line for each control that is not disabled.
std::vector<std::string> describe_controls(VideoKernel& kernel, int fd);

}  // namespace ninedot
