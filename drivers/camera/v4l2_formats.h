#pragma once
/// What a V4L2 camera offers, and which of it to take.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/pixel_format.h"
#include "drivers/camera/video_kernel.h"

namespace ninedot {

/// One size, or all sizes up to one.
struct OfferedSize {
  int width_px = 0, height_px = 0;
  int least_width_px = 0, least_height_px = 0;  ///< equal to the above for a single size
  int width_step_px = 1, height_step_px = 1;
  double max_rate_hz = 0;  ///< 0 = the driver does not say

  /// \param width, height  [px]
  bool contains(int width, int height) const noexcept;
};

struct OfferedFormat {
  std::uint32_t fourcc = 0;
  const PixelFormat* known = nullptr;  ///< nullptr: we can't read it
  std::vector<OfferedSize> sizes;      ///< empty: the driver does not say, any may work
};

/// "YUYV"; unprintable bytes become '?'.
std::string fourcc_text(std::uint32_t fourcc);

/// Asks the driver. \param fd  an open capture device
std::vector<OfferedFormat> read_offered_formats(VideoKernel& kernel, int fd);

/// "GREY, NV12 640x480 60 Hz, 1280x720 30 Hz": one line for all formats of the same sizes, one for those not readable.
std::vector<std::string> describe_offers(const std::vector<OfferedFormat>& offers);

/// The format asked for; with "auto" the first in the order of pixel_formats() that reaches the rate at this size, else
/// the fastest; MJPG only where nothing else has the size.
/// \return  nullptr: nothing fits
const OfferedFormat* choose_format(const std::vector<OfferedFormat>& offers, const CameraRequest& request);

}  // namespace ninedot
