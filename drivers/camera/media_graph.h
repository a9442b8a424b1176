#pragma once
/// The kernel's media graphs: which sensor feeds which video node, and over which sub-devices.
///
/// A sensor behind a bare receiver is not one device but a chain, each part with a node of its own: the sensor
/// (formats, exposure, gain, blanking), the receiver, and the video node where pictures come out. `camera.device` names
/// such a camera by its sensor, "sensor:ov9281", because the numbers of all nodes change from one start to the next.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/camera/video_kernel.h"

namespace ninedot {

/// Where the system keeps nodes, and where it tells which is which; tests have others.
struct SystemFolders {
  std::string devices = "/dev";
  std::string video = "/sys/class/video4linux";
};

struct MediaEntity {
  std::uint32_t id = 0;
  std::uint32_t function = 0;  ///< MEDIA_ENT_F_... [1]
  std::string name;            ///< "ov9281 10-0060"
  std::string node;            ///< "/dev/v4l-subdev0"; empty: it has none
};

/// From a source pad to a sink pad.
struct MediaLink {
  std::uint32_t source_id = 0;         ///< entity
  std::uint32_t source_pad_index = 0;  ///< of that entity
  std::uint32_t sink_id = 0;
  std::uint32_t sink_pad_index = 0;
  std::uint32_t flags = 0;  ///< MEDIA_LNK_FL_...
  bool operator==(const MediaLink&) const = default;
};

struct MediaGraph {
  std::string device;  ///< "/dev/media0"
  std::string origin;  ///< "unicam, platform:fe801000.csi"
  std::vector<MediaEntity> entities;
  std::vector<MediaLink> links;

  const MediaEntity& entity(std::uint32_t id) const;  ///< one of its own (contract)
};

struct MediaGraphs {
  std::vector<MediaGraph> graphs;
  std::string problem;  ///< why the first one that could not be read was not, one line; empty: all were
  int error = 0;        ///< errno of it
};

/// Asks every /dev/mediaN. Allocates. Threads: any.
MediaGraphs read_media_graphs(VideoKernel& kernel, const SystemFolders& folders);

/// From a sensor down to a video node.
struct SensorRoute {
  MediaGraph graph;
  MediaEntity sensor;
  std::vector<MediaLink> links;  ///< in the order of the pictures' way, not empty
  std::string node;              ///< where the pictures come out: "/dev/video0"
};

/// One for each video node that can be reached from this sensor, the shortest first. Links that are off count, unless
/// they can't be switched on.
std::vector<SensorRoute> routes_from(const MediaGraph& graph, const MediaEntity& sensor);

/// Those with a node of their own: a webcam's graph has a sensor too, which nobody can talk to.
std::vector<MediaEntity> sensors_of(const MediaGraph& graph);

/// "ov9281 10-0060 -> unicam -> /dev/video0"
std::string describe_route(const SensorRoute& route);

inline constexpr std::string_view kSensorPrefix = "sensor:";

/// Of "sensor:NAME": the sensor whose name begins so, whatever the case; of several video nodes the nearest that
/// captures pictures.
/// Throws CameraRefused: no such sensor (ENODEV), several (EINVAL), no way from it to a video node (EINVAL).
SensorRoute find_sensor(VideoKernel& kernel, const std::string& device, const SystemFolders& folders);

/// Of a node's path: the sensor in front of it.
/// \return  nothing: there is none, or its graph can't be read
/// Throws CameraRefused (EINVAL): several can be, and not just one is connected.
std::optional<SensorRoute> find_sensor_in_front_of(VideoKernel& kernel, const std::string& device,
                                                   const SystemFolders& folders);

/// Switches the route's links on, those that exclude them off.
/// \param device  how errors call the camera. Throws CameraRefused.
void enable_links(VideoKernel& kernel, const SensorRoute& route, const std::string& device);

}  // namespace ninedot
