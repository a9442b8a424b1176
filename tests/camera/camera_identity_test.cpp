#include "drivers/camera/camera_identity.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "drivers/camera/camera_device.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// A system with one camera at a USB socket, as /sys shows it.
class CameraIdentity : public testing::Test {
 protected:
  CameraIdentity() {
    std::string pattern = (fs::temp_directory_path() / "ninedot-identity-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
    std::strcpy(reinterpret_cast<char*>(capability_.card), "HD Webcam: HD Webcam");
    std::strcpy(reinterpret_cast<char*>(capability_.bus_info), "usb-0000:00:14.0-1");
    fs::create_directories(root_ / "dev/by-id");
    fs::create_directories(root_ / "class/video3");
    std::ofstream(root_ / "dev/video3") << "";
    fs::create_symlink("../video3", root_ / "dev/by-id/webcam");
  }
  ~CameraIdentity() override { fs::remove_all(root_); }
  CameraIdentity(const CameraIdentity&) = delete;
  CameraIdentity& operator=(const CameraIdentity&) = delete;

  /// Puts the camera into a socket.
  void plug(const std::string& socket, const std::string& serial) {
    const fs::path camera = root_ / "devices" / socket;
    fs::create_directories(camera / "1-1:1.0");
    std::ofstream(camera / "idVendor") << "046d\n";
    std::ofstream(camera / "idProduct") << "0825\n";
    if (!serial.empty()) std::ofstream(camera / "serial") << serial << "\n";
    fs::remove(root_ / "class/video3/device");
    fs::create_symlink(camera / "1-1:1.0", root_ / "class/video3/device");
  }
  std::string identity(const std::string& node = "video3") const {
    return v4l2_identity((root_ / "dev" / node).string(), capability_, (root_ / "class").string());
  }

  fs::path root_;
  v4l2_capability capability_{};
};

TEST_F(CameraIdentity, OfAUsbCameraIsTheSameInEverySocketAndUnderEveryName) {
  plug("usb1/1-1", "1A2B3C");
  EXPECT_EQ(identity(), "usb-046d:0825-1A2B3C");
  EXPECT_EQ(identity("by-id/webcam"), "usb-046d:0825-1A2B3C");
  plug("usb2/2-4.1", "1A2B3C");
  EXPECT_EQ(identity(), "usb-046d:0825-1A2B3C");
  plug("usb3/3-1", "");
  EXPECT_EQ(identity(), "usb-046d:0825");
}

TEST_F(CameraIdentity, OfOtherCamerasIsTheirNameAndWhereTheyAreConnected) {
  std::strcpy(reinterpret_cast<char*>(capability_.card), "unicam");
  std::strcpy(reinterpret_cast<char*>(capability_.bus_info), "platform:fe801000.csi");
  EXPECT_EQ(identity(), "unicam@platform:fe801000.csi");
  std::strcpy(reinterpret_cast<char*>(capability_.bus_info), "usb-0000:00:14.0-1");
  EXPECT_EQ(identity(), "unicam") << "a system that does not tell more: the socket is left out";
}

TEST(LibcameraIdentity, LeavesOutTheSocketOfAUsbCamera) {
  EXPECT_EQ(libcamera_identity("\\_SB_.PCI0.XHCI.RHUB.HS01-1:1.0-046d:0825"), "usb-046d:0825");
  EXPECT_EQ(libcamera_identity("/base/soc/i2c0mux/i2c@1/imx296@1a"), "/base/soc/i2c0mux/i2c@1/imx296@1a");
  EXPECT_EQ(libcamera_identity(""), "");
}

TEST(SameCamera, DiffersWhereBothAreKnownAndDiffer) {
  EXPECT_TRUE(is_same_camera("", "usb-046d:0825"));
  EXPECT_TRUE(is_same_camera("usb-046d:0825-A", "usb-046d:0825-A"));
  EXPECT_TRUE(is_same_camera("usb-046d:0825-A", "usb-046d:0825")) << "of one of them the number is not known";
  EXPECT_FALSE(is_same_camera("usb-046d:0825-A", "usb-046d:0825-B"));
  EXPECT_FALSE(is_same_camera("usb-046d:0825", "usb-046d:0826"));
  EXPECT_FALSE(is_same_camera("unicam@a", "unicam@b"));
  EXPECT_FALSE(is_same_camera("usb-", "usb-046d:0825"));
}

}  // namespace
}  // namespace ninedot
