#include "drivers/camera/v4l2_list.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>

#include "drivers/camera/camera_identity.h"
#include "drivers/camera/v4l2_controls.h"
#include "drivers/camera/v4l2_device.h"
#include "drivers/camera/v4l2_formats.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

template <std::size_t N>
std::string text_of(const __u8 (&field)[N]) {
  const auto* const text = reinterpret_cast<const char*>(field);
  return std::string(text, ::strnlen(text, N));
}

/// video2 before video10.
bool comes_before(const std::string& a, const std::string& b) {
  return a.size() != b.size() ? a.size() < b.size() : a < b;
}

std::vector<std::string> video_nodes(const std::string& folder) {
  std::vector<std::string> nodes;
  std::error_code unreadable;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, unreadable)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("video") && name.size() > 5 &&
        std::ranges::all_of(name.substr(5), [](char c) { return c >= '0' && c <= '9'; }))
      nodes.push_back(entry.path().string());
  }
  std::ranges::sort(nodes, comes_before);
  return nodes;
}

std::string steady_name(const std::string& folder, const std::string& node) {
  for (const char* const kind : {"/v4l/by-id", "/v4l/by-path"}) {
    std::error_code missing;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder + kind, missing))
      if (std::error_code differ; fs::equivalent(entry.path(), node, differ)) return entry.path().string();
  }
  return {};
}

std::optional<CameraListing> list_one(VideoKernel& kernel, const std::string& folder, const std::string& node) {
  CameraListing listing;
  listing.device = node;
  const int fd = kernel.open(node.c_str());
  if (fd < 0) {
    listing.problem = describe_open_failure(node, -fd);
    return listing;
  }
  v4l2_capability capability{};
  const bool is_v4l2 = kernel.ioctl(fd, VIDIOC_QUERYCAP, &capability) >= 0;
  const std::uint32_t can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  const bool is_camera = is_v4l2 && (can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) != 0;
  if (is_camera) {
    listing.name =
        fmt::format("{} ({}, {})", text_of(capability.card), text_of(capability.driver), text_of(capability.bus_info));
    listing.steady_device = steady_name(folder, node);
    listing.identity = v4l2_identity(node, capability);
    if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0) listing.problem = "multi-planar interface: use it through libcamera";
    listing.formats = describe_offers(read_offered_formats(kernel, fd));
    listing.controls = describe_controls(kernel, fd);
  }
  kernel.close(fd);
  return is_camera ? std::optional(listing) : std::nullopt;
}

}  // namespace

std::vector<CameraListing> list_v4l2_cameras(VideoKernel& kernel, const std::string& folder) {
  std::vector<CameraListing> cameras;
  for (const std::string& node : video_nodes(folder))
    if (auto listing = list_one(kernel, folder, node)) cameras.push_back(*std::move(listing));
  return cameras;
}

}  // namespace ninedot
