#pragma once
/// The V4L2 cameras of this machine, for people.
#include <string>
#include <vector>

#include "drivers/camera/media_graph.h"
#include "drivers/camera/video_kernel.h"

namespace ninedot {

struct CameraListing {
  std::string device;                 ///< for camera.device
  std::string name;                   ///< "HD Webcam (uvcvideo, usb-0000:00:14.0-1)"
  std::string steady_device;          ///< of /dev/v4l/by-id or by-path: stays when numbers change; empty: none
  std::string identity;               ///< for `camera_id` of a calibration (camera_identity.h)
  std::string problem;                ///< why nothing more is known; empty: none
  std::string path;                   ///< of a sensor behind a media graph: "ov9281 10-0060 -> unicam -> /dev/video0"
  std::string now;                    ///< of such a sensor: "Y8 1280x800, 2.5 to 143.7 Hz, line time 7.65 us"
  std::vector<std::string> formats;   ///< "GREY 640x480 60 Hz, 1280x720 30 Hz"
  std::vector<std::string> controls;  ///< "Gain: 0 to 100 step 1, now 16"
};

/// Asks every sensor of the media graphs, and every node /dev/videoN but theirs; those that capture no pictures are
/// left out. Sets nothing.
std::vector<CameraListing> list_v4l2_cameras(VideoKernel& kernel = linux_video_kernel(),
                                             const SystemFolders& folders = {});

}  // namespace ninedot
