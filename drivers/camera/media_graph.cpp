// Reading a graph takes two questions: how much there is, then all of it; between the two it may have grown.
#include "drivers/camera/media_graph.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/media.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "base/contract.h"
#include "base/one_line.h"
#include "drivers/camera/camera_device.h"
#include "drivers/camera/open_failure.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// A graph that grows with every question must not keep us for ever.
constexpr int kMaxReadings = 5;

class Node {
 public:
  Node(VideoKernel& kernel, const std::string& path) : kernel_(kernel), fd_(kernel.open(path.c_str())) {}
  ~Node() {
    if (fd_ >= 0) kernel_.close(fd_);
  }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  int fd() const noexcept { return fd_; }

 private:
  VideoKernel& kernel_;
  const int fd_;
};

struct Topology {
  std::vector<media_v2_entity> entities;
  std::vector<media_v2_interface> interfaces;
  std::vector<media_v2_pad> pads;
  std::vector<media_v2_link> links;
};

template <typename T>
std::uint64_t address_of(std::vector<T>& list, std::uint32_t count) {
  list.resize(count);
  return reinterpret_cast<std::uintptr_t>(list.data());
}

/// \return  0, or -errno
int read_topology(VideoKernel& kernel, int fd, Topology& topology) {
  int result = -ENOSPC;
  for (int i = 0; i < kMaxReadings && result == -ENOSPC; ++i) {
    media_v2_topology sizes{};
    if (result = kernel.ioctl(fd, MEDIA_IOC_G_TOPOLOGY, &sizes); result < 0) return result;
    sizes.ptr_entities = address_of(topology.entities, sizes.num_entities);
    sizes.ptr_interfaces = address_of(topology.interfaces, sizes.num_interfaces);
    sizes.ptr_pads = address_of(topology.pads, sizes.num_pads);
    sizes.ptr_links = address_of(topology.links, sizes.num_links);
    result = kernel.ioctl(fd, MEDIA_IOC_G_TOPOLOGY, &sizes);  // ENOSPC: it has grown meanwhile
    if (result < 0) continue;
    topology.entities.resize(std::min<std::size_t>(topology.entities.size(), sizes.num_entities));
    topology.interfaces.resize(std::min<std::size_t>(topology.interfaces.size(), sizes.num_interfaces));
    topology.pads.resize(std::min<std::size_t>(topology.pads.size(), sizes.num_pads));
    topology.links.resize(std::min<std::size_t>(topology.links.size(), sizes.num_links));
  }
  return result;
}

template <std::size_t N>
std::string text_of(const char (&field)[N]) {
  return one_line(std::string(field, ::strnlen(field, N)));
}

/// "81:0" -> "/dev/video0"
std::map<std::string, std::string> nodes_by_number(const SystemFolders& folders) {
  std::map<std::string, std::string> nodes;
  std::error_code unreadable;
  for (const fs::directory_entry& entry : fs::directory_iterator(folders.video, unreadable)) {
    std::ifstream stream(entry.path() / "dev");
    std::string number;
    if (std::getline(stream, number))
      nodes[number] = fmt::format("{}/{}", folders.devices, entry.path().filename().string());
  }
  return nodes;
}

MediaGraph graph_of(const Topology& topology, const std::map<std::string, std::string>& nodes) {
  MediaGraph graph;
  for (const media_v2_entity& entity : topology.entities)
    graph.entities.push_back({entity.id, entity.function, text_of(entity.name), {}});
  std::map<std::uint32_t, media_v2_pad> pads;
  for (const media_v2_pad& pad : topology.pads) pads[pad.id] = pad;
  for (const media_v2_link& link : topology.links) {
    const std::uint32_t type = link.flags & static_cast<std::uint32_t>(MEDIA_LNK_FL_LINK_TYPE);
    if (type == MEDIA_LNK_FL_DATA_LINK && pads.contains(link.source_id) && pads.contains(link.sink_id)) {
      const media_v2_pad &source = pads[link.source_id], &sink = pads[link.sink_id];
      graph.links.push_back({source.entity_id, source.index, sink.entity_id, sink.index, link.flags});
    }
    if (type != MEDIA_LNK_FL_INTERFACE_LINK) continue;
    const auto interface = std::ranges::find(topology.interfaces, link.source_id, &media_v2_interface::id);
    const auto entity = std::ranges::find(graph.entities, link.sink_id, &MediaEntity::id);
    if (interface == topology.interfaces.end() || entity == graph.entities.end()) continue;
    const auto node = nodes.find(fmt::format("{}:{}", interface->devnode.major, interface->devnode.minor));
    if (node != nodes.end()) entity->node = node->second;
  }
  return graph;
}

bool is_media_node(const std::string& name) {
  return name.starts_with("media") && name.size() > 5 &&
         std::ranges::all_of(name.substr(5), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

const MediaEntity& MediaGraph::entity(std::uint32_t id) const {
  const auto found = std::ranges::find(entities, id, &MediaEntity::id);
  EXPECTS(found != entities.end());
  return *found;
}

MediaGraphs read_media_graphs(VideoKernel& kernel, const SystemFolders& folders) {
  std::vector<std::string> paths;
  std::error_code unreadable;
  for (const fs::directory_entry& entry : fs::directory_iterator(folders.devices, unreadable))
    if (is_media_node(entry.path().filename().string())) paths.push_back(entry.path().string());
  std::ranges::sort(paths);
  const std::map<std::string, std::string> nodes = nodes_by_number(folders);

  MediaGraphs read;
  for (const std::string& path : paths) {
    const Node node(kernel, path);
    Topology topology;
    media_device_info info{};
    const int error = node.fd() < 0 ? node.fd() : read_topology(kernel, node.fd(), topology);
    if (error < 0) {
      if (read.problem.empty()) read.problem = describe_open_failure(path, -error), read.error = -error;
      continue;
    }
    read.graphs.push_back(graph_of(topology, nodes));
    read.graphs.back().device = path;
    if (kernel.ioctl(node.fd(), MEDIA_IOC_DEVICE_INFO, &info) >= 0)
      read.graphs.back().origin = fmt::format("{}, {}", text_of(info.driver), text_of(info.bus_info));
  }
  return read;
}

void enable_links(VideoKernel& kernel, const SensorRoute& route, const std::string& device) {
  const Node media(kernel, route.graph.device);
  if (media.fd() < 0) throw CameraRefused(describe_open_failure(route.graph.device, -media.fd()), -media.fd());
  const auto set = [&](const MediaLink& link, bool is_on) {
    media_link_desc change{};
    change.source = {link.source_id, static_cast<__u16>(link.source_pad_index), MEDIA_PAD_FL_SOURCE, {}};
    change.sink = {link.sink_id, static_cast<__u16>(link.sink_pad_index), MEDIA_PAD_FL_SINK, {}};
    change.flags = is_on ? MEDIA_LNK_FL_ENABLED : 0;
    const int error = kernel.ioctl(media.fd(), MEDIA_IOC_SETUP_LINK, &change);
    if (error >= 0) return;
    throw CameraRefused(
        fmt::format("{}: the link from '{}' to '{}' can't be switched {}: {}{}", device,
                    route.graph.entity(link.source_id).name, route.graph.entity(link.sink_id).name,
                    is_on ? "on" : "off", std::strerror(-error),
                    error == -EBUSY ? ": stop the program that uses the camera (fuser /dev/video* names it)" : ""),
        -error);
  };
  for (const MediaLink& link : route.links) {
    if ((link.flags & MEDIA_LNK_FL_ENABLED) != 0) continue;
    // A pad takes pictures from one source at a time.
    for (const MediaLink& other : route.graph.links) {
      const bool is_rival =
          other.sink_id == link.sink_id && other.sink_pad_index == link.sink_pad_index && other != link;
      if (is_rival && (other.flags & (MEDIA_LNK_FL_ENABLED | MEDIA_LNK_FL_IMMUTABLE)) == MEDIA_LNK_FL_ENABLED)
        set(other, false);
    }
    set(link, true);
  }
}

}  // namespace ninedot
