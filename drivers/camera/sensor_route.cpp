// From a name or a node to the sensor and the way its pictures take. A graph may branch (a raw node beside an image
// processor's, metadata beside pictures) and several sensors may share one receiver.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/media.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <filesystem>
#include <map>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/media_graph.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// V4L2's capabilities of a node; 0: it can't be asked.
std::uint32_t capabilities_of(VideoKernel& kernel, const std::string& node) {
  const int fd = kernel.open(node.c_str());
  if (fd < 0) return 0;
  v4l2_capability capability{};
  const bool is_answered = kernel.ioctl(fd, VIDIOC_QUERYCAP, &capability) >= 0;
  kernel.close(fd);
  if (!is_answered) return 0;
  return (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
}

bool begins_with(const std::string& name, std::string_view start) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return name.size() >= start.size() &&
         std::equal(start.begin(), start.end(), name.begin(), [&](char a, char b) { return lower(a) == lower(b); });
}

struct NamedSensor {
  const MediaGraph* graph;
  MediaEntity sensor;
};

std::string names_of(const std::vector<NamedSensor>& sensors) {
  std::vector<std::string> names;
  for (const NamedSensor& named : sensors) names.push_back(fmt::format("'{}{}'", kSensorPrefix, named.sensor.name));
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The first that captures pictures. Where none can be asked (all busy, or not permitted), the first: opening it says
/// what is in the way.
const SensorRoute* nearest_of_pictures(VideoKernel& kernel, const std::vector<SensorRoute>& routes) {
  const SensorRoute* nearest = nullptr;
  for (const SensorRoute& route : routes) {
    const std::uint32_t can = capabilities_of(kernel, route.node);
    if ((can & V4L2_CAP_VIDEO_CAPTURE) != 0) return &route;
    if (nearest == nullptr && (can == 0 || (can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0)) nearest = &route;
  }
  return nearest;
}

/// The sensors that can feed this node; those alone whose links are all on, where there are such.
std::vector<SensorRoute> routes_to(const MediaGraphs& read, const std::string& node) {
  std::vector<SensorRoute> all, connected;
  for (const MediaGraph& graph : read.graphs)
    for (const MediaEntity& sensor : sensors_of(graph))
      for (const SensorRoute& route : routes_from(graph, sensor)) {
        if (route.node != node) continue;
        all.push_back(route);
        const auto is_on = [](const MediaLink& link) { return (link.flags & MEDIA_LNK_FL_ENABLED) != 0; };
        if (std::ranges::all_of(route.links, is_on)) connected.push_back(route);
      }
  return connected.empty() ? all : connected;
}

}  // namespace

std::vector<MediaEntity> sensors_of(const MediaGraph& graph) {
  std::vector<MediaEntity> sensors;
  for (const MediaEntity& entity : graph.entities)
    if (entity.function == MEDIA_ENT_F_CAM_SENSOR && !entity.node.empty()) sensors.push_back(entity);
  return sensors;
}

std::vector<SensorRoute> routes_from(const MediaGraph& graph, const MediaEntity& sensor) {
  std::vector<MediaLink> usable;
  for (const MediaLink& link : graph.links)
    if ((link.flags & (MEDIA_LNK_FL_ENABLED | MEDIA_LNK_FL_IMMUTABLE)) != MEDIA_LNK_FL_IMMUTABLE)
      usable.push_back(link);
  // Of two ways of one length the one that is on.
  std::stable_partition(usable.begin(), usable.end(),
                        [](const MediaLink& link) { return (link.flags & MEDIA_LNK_FL_ENABLED) != 0; });

  std::vector<SensorRoute> routes;
  std::map<std::uint32_t, std::vector<MediaLink>> way_to{{sensor.id, {}}};
  std::deque<std::uint32_t> open{sensor.id};
  for (; !open.empty(); open.pop_front()) {
    for (const MediaLink& link : usable) {
      if (link.source_id != open.front() || way_to.contains(link.sink_id)) continue;
      std::vector<MediaLink> way = way_to[open.front()];
      way.push_back(link);
      const MediaEntity& next = graph.entity(link.sink_id);
      if (next.function == MEDIA_ENT_F_IO_V4L && !next.node.empty()) routes.push_back({graph, sensor, way, next.node});
      open.push_back(link.sink_id);
      way_to[link.sink_id] = std::move(way);
    }
  }
  return routes;
}

std::string describe_route(const SensorRoute& route) {
  std::string text = route.sensor.name;
  for (std::size_t i = 0; i + 1 < route.links.size(); ++i)
    text += " -> " + route.graph.entity(route.links[i].sink_id).name;
  return text + " -> " + route.node;
}

SensorRoute find_sensor(VideoKernel& kernel, const std::string& device, const SystemFolders& folders) {
  const MediaGraphs read = read_media_graphs(kernel, folders);
  const std::string_view wanted = std::string_view(device).substr(kSensorPrefix.size());
  std::vector<NamedSensor> all, fitting;
  for (const MediaGraph& graph : read.graphs)
    for (const MediaEntity& sensor : sensors_of(graph)) {
      all.push_back({&graph, sensor});
      if (begins_with(sensor.name, wanted)) fitting.push_back(all.back());
    }
  // One whose whole name this is is meant, though another's name may go on after it.
  for (const NamedSensor& named : fitting)
    if (named.sensor.name.size() == wanted.size() && fitting.size() > 1) {
      fitting = {named};
      break;
    }
  if (fitting.empty())
    throw CameraRefused(
        all.empty() && read.error != 0 ? fmt::format("{}: {}", device, read.problem)
        : all.empty()
            ? fmt::format("{}: there is no sensor: connect it; its driver says in dmesg what it lacks", device)
            : fmt::format("{}: no sensor's name begins so; there is {}", device, names_of(all)),
        all.empty() && read.error != 0 ? read.error : ENODEV);
  if (fitting.size() > 1)
    throw CameraRefused(fmt::format("{}: several sensors' names begin so: write one of {}", device, names_of(fitting)),
                        EINVAL);
  const NamedSensor& found = fitting.front();
  const std::vector<SensorRoute> routes = routes_from(*found.graph, found.sensor);
  const SensorRoute* const route = nearest_of_pictures(kernel, routes);
  if (route == nullptr)
    throw CameraRefused(
        fmt::format("{}: no link leads from '{}' to a node that captures pictures: `media-ctl -p -d {}` "
                    "shows what is connected",
                    device, found.sensor.name, found.graph->device),
        EINVAL);
  return *route;
}

std::optional<SensorRoute> find_sensor_in_front_of(VideoKernel& kernel, const std::string& device,
                                                   const SystemFolders& folders) {
  std::error_code missing;
  const fs::path node = fs::path(folders.devices) / fs::canonical(device, missing).filename();
  const std::vector<SensorRoute> routes = routes_to(read_media_graphs(kernel, folders), node.string());
  if (routes.empty()) return std::nullopt;
  if (routes.size() == 1) return routes.front();
  std::vector<std::string> names;
  for (const SensorRoute& route : routes) names.push_back(fmt::format("'{}{}'", kSensorPrefix, route.sensor.name));
  throw CameraRefused(
      fmt::format("{}: several sensors can be in front of it: write one of {}", device, fmt::join(names, ", ")),
      EINVAL);
}

}  // namespace ninedot
