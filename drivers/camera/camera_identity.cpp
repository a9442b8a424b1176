#include "drivers/camera/camera_identity.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/one_line.h"
#include "drivers/camera/camera_device.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUsb = "usb-";
constexpr std::size_t kTypeLength = 9;  // "046d:0825"

/// The first line of a small file of the system's; empty: there is none.
std::string attribute(const fs::path& path) {
  std::ifstream stream(path);
  std::string line;
  std::getline(stream, line);
  return one_line(line);
}

/// Of a USB camera: the node's device is an interface, and the folder above it the camera.
std::string usb_identity(const std::string& device, const std::string& system) {
  std::error_code missing;
  const fs::path node = fs::canonical(device, missing);
  const fs::path interface = fs::canonical(fs::path(system) / node.filename() / "device", missing);
  if (missing) return {};
  const fs::path camera = interface.parent_path();
  const std::string vendor = attribute(camera / "idVendor"), product = attribute(camera / "idProduct");
  if (vendor.empty() || product.empty()) return {};
  const std::string serial = attribute(camera / "serial");
  return fmt::format("{}{}:{}{}{}", kUsb, vendor, product, serial.empty() ? "" : "-", serial);
}

template <std::size_t N>
std::string text_of(const __u8 (&field)[N]) {
  const auto* const text = reinterpret_cast<const char*>(field);
  return one_line(std::string(text, ::strnlen(text, N)));
}

bool is_type(std::string_view text) noexcept {
  return text.size() == kTypeLength && text[4] == ':' &&
         std::ranges::all_of(text, [](char c) { return c == ':' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

}  // namespace

std::string v4l2_identity(const std::string& device, const v4l2_capability& capability, const std::string& system) {
  if (std::string usb = usb_identity(device, system); !usb.empty()) return usb;
  const std::string card = text_of(capability.card), bus = text_of(capability.bus_info);
  if (card.empty() && bus.empty()) return {};
  return bus.starts_with(kUsb) ? card : fmt::format("{}@{}", card, bus);  // a USB bus names the socket
}

std::string libcamera_identity(const std::string& id) {
  const std::size_t length = id.size();
  if (length <= kTypeLength) return id;
  const std::string type = id.substr(length - kTypeLength);
  return id[length - kTypeLength - 1] == '-' && is_type(type) ? std::string(kUsb) + type : id;
}

bool is_same_camera(std::string_view a, std::string_view b) noexcept {
  if (a.empty() || b.empty() || a == b) return true;
  const std::size_t type_end = kUsb.size() + kTypeLength;
  const auto is_usb = [&](std::string_view id) {
    return id.starts_with(kUsb) && is_type(id.substr(kUsb.size(), kTypeLength));
  };
  const bool is_one_type = is_usb(a) && is_usb(b) && a.substr(0, type_end) == b.substr(0, type_end);
  return is_one_type && (a.size() == type_end || b.size() == type_end);
}

void check_identity(const std::string& device, const std::string& identity, const std::string& calibrated) {
  if (is_same_camera(identity, calibrated)) return;
  throw CameraRefused(fmt::format("{}: this camera is '{}', but the calibration is of '{}': connect that one, or set "
                                  "camera.calibration to a calibration of this one",
                                  device, identity, calibrated),
                      0);
}

}  // namespace ninedot
