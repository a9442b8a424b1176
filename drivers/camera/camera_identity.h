#pragma once
/// Which camera this is, in words that are the same after a reboot and in another socket: what a calibration names in
/// `camera_id`.
///
/// | camera | identity |
/// |---|---|
/// | USB | "usb-046d:0825-SERIAL": vendor and product, and the serial number where the camera has one |
/// | others of V4L2 | "CARD@BUS": the driver's name for it, and where it is connected |
/// | others of libcamera | its id: where it is connected |
///
/// USB cameras of one type without serial numbers can't be told apart, and some types give all the same number.
#include <string>
#include <string_view>

struct v4l2_capability;

namespace ninedot {

/// \param device  its node, or a link to it \param system  /sys/class/video4linux; tests have another
std::string v4l2_identity(const std::string& device, const v4l2_capability& capability,
                          const std::string& system = "/sys/class/video4linux");

/// \param id  libcamera's; of a USB camera it ends with vendor and product, and has no serial number
std::string libcamera_identity(const std::string& id);

/// Equal, or of one USB type where a serial number is known of one of them only. Empty: unknown, and may be any.
bool is_same_camera(std::string_view a, std::string_view b) noexcept;

/// Throws CameraRefused: both are known, and differ. \param device  how errors call the camera
void check_identity(const std::string& device, const std::string& identity, const std::string& calibrated);

}  // namespace ninedot
