#include "drivers/camera/v4l2_list.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>

#include "drivers/camera/camera_identity.h"
#include "drivers/camera/media_sensor.h"
#include "drivers/camera/open_failure.h"
#include "drivers/camera/v4l2_controls.h"
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

std::optional<CameraListing> list_one(VideoKernel& kernel, const SystemFolders& folders, const std::string& node) {
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
    listing.steady_device = steady_name(folders.devices, node);
    listing.identity = v4l2_identity(node, capability, folders.video);
    if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0) listing.problem = "multi-planar interface: use it through libcamera";
    listing.formats = describe_offers(read_offered_formats(kernel, fd));
    listing.controls = describe_controls(kernel, fd);
  }
  kernel.close(fd);
  return is_camera ? std::optional(listing) : std::nullopt;
}

/// Of a sensor: what its node and the video node say together.
CameraListing list_sensor(VideoKernel& kernel, const SystemFolders& folders, const std::string& device) {
  CameraListing listing;
  listing.device = device;
  try {
    const MediaSensor sensor(kernel, find_sensor(kernel, device, folders), device);
    const SensorRoute& route = sensor.route();
    listing.name = route.graph.origin;
    listing.path = describe_route(route);
    listing.now = sensor.describe_now();
    listing.controls = describe_controls(kernel, sensor.fd());
    const int fd = kernel.open(route.node.c_str());
    if (fd < 0) throw CameraRefused(describe_open_failure(route.node, -fd), -fd);
    v4l2_capability capability{};
    if (kernel.ioctl(fd, VIDIOC_QUERYCAP, &capability) >= 0)
      listing.identity = v4l2_identity(route.node, capability, folders.video);
    CameraRequest no_size;  // so none is cut out
    no_size.width_px = no_size.height_px = 0;
    listing.formats = describe_offers(sensor.offers(read_offered_formats(kernel, fd), no_size));
    kernel.close(fd);
  } catch (const CameraRefused& refused) {
    listing.problem = refused.what();
  }
  return listing;
}

}  // namespace

std::vector<CameraListing> list_v4l2_cameras(VideoKernel& kernel, const SystemFolders& folders) {
  std::vector<CameraListing> cameras;
  std::vector<std::string> of_sensors;
  for (const MediaGraph& graph : read_media_graphs(kernel, folders).graphs)
    for (const MediaEntity& sensor : sensors_of(graph)) {
      cameras.push_back(list_sensor(kernel, folders, std::string(kSensorPrefix) + sensor.name));
      for (const SensorRoute& route : routes_from(graph, sensor)) of_sensors.push_back(route.node);
    }
  for (const std::string& node : video_nodes(folders.devices))
    if (std::ranges::find(of_sensors, node) == of_sensors.end())
      if (auto listing = list_one(kernel, folders, node)) cameras.push_back(*std::move(listing));
  return cameras;
}

}  // namespace ninedot
