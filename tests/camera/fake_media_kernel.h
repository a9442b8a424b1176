#pragma once
/// A made-up board with a sensor behind a receiver, as Linux 6.12 has them: bcm2835-unicam, ov9282.c, imx296.c. The
/// video node is FakeVideoKernel's.
#include <linux/media-bus-format.h>
#include <linux/media.h>
#include <linux/v4l2-subdev.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "drivers/camera/media_graph.h"
#include "fake_video_kernel.h"
#include "fmt/format.h"

namespace ninedot {

/// What a sensor's driver says and does. The numbers are those of the drivers' sources.
struct FakeSensor {
  struct Mode {
    int width, height, hblank, vblank_min, vblank_max, vblank_default;
  };
  std::string name;
  std::vector<std::uint32_t> codes;
  std::vector<Mode> modes;
  std::map<std::uint32_t, std::int64_t> pixel_rate;  // by code
  bool hblank_is_read_only = false;
  int exposure_max = 0;  // 0: the frame's lines less exposure_margin
  int exposure_margin = 0;
  int gain_min = 0, gain_max = 0, gain = 0, exposure = 0;
  v4l2_rect bounds{};
  bool can_crop = false;
};

/// Linux 6.12, drivers/media/i2c/ov9282.c, with a clock that stops between frames ("clock-noncontinuous").
inline FakeSensor fake_ov9281() {
  return {.name = "ov9281 10-0060",
          .codes = {MEDIA_BUS_FMT_Y10_1X10, MEDIA_BUS_FMT_Y8_1X8},
          .modes = {{1280, 800, 250, 110, 51540, 1022},
                    {1280, 720, 250, 41, 51540, 1022},
                    {640, 400, 890, 22, 51540, 1022}},
          .pixel_rate = {{MEDIA_BUS_FMT_Y10_1X10, 160'000'000}, {MEDIA_BUS_FMT_Y8_1X8, 200'000'000}},
          .exposure_margin = 25,
          .gain_min = 0x10,
          .gain_max = 0xff,
          .gain = 0x10,
          .exposure = 0x282,
          .bounds = {8, 8, 1280, 800}};
}

/// Linux 6.12, drivers/media/i2c/imx296.c, monochrome.
inline FakeSensor fake_imx296() {
  const int hblank = 1100 * 16 / 10 - 1456;  // HMAX 1100 at 74.25 MHz, in pixels at 118.8 MHz
  const auto mode = [&](int width, int height) {
    return FakeSensor::Mode{width, height, hblank, 30, 1048575 - 1088, 30};
  };
  return {.name = "imx296 10-001a",
          .codes = {MEDIA_BUS_FMT_Y10_1X10},
          .modes = {mode(1456, 1088), mode(728, 544)},
          .pixel_rate = {{MEDIA_BUS_FMT_Y10_1X10, 118'800'000}},
          .hblank_is_read_only = true,
          .exposure_max = 1048575,
          .gain_min = 0,
          .gain_max = 480,
          .gain = 0,
          .exposure = 1104,
          .bounds = {0, 0, 1456, 1088},
          .can_crop = true};
}

class FakeMediaKernel final : public VideoKernel {
 public:
  static constexpr std::uint32_t kSensor = 1, kReceiver = 3, kImage = 7, kEmbedded = 11, kSecond = 15;
  static constexpr int kMediaFd = 100, kSensorFd = 101, kReceiverFd = 102, kSecondFd = 103, kEmbeddedFd = 104;

  explicit FakeMediaKernel(FakeSensor model) : sensor(std::move(model)) {
    code = sensor.codes.front();
    select(sensor.modes.front());
    values[V4L2_CID_EXPOSURE] = sensor.exposure, values[V4L2_CID_ANALOGUE_GAIN] = sensor.gain;
    video.capabilities |= V4L2_CAP_IO_MC;
    video.card = "unicam", video.bus_info = "platform:fe801000.csi";
    for (const std::uint32_t fourcc : {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_Y10P, V4L2_PIX_FMT_Y10})
      video.formats.push_back({fourcc, {}, 0});  // the receiver takes any size
    folders.devices = folders.video = std::string(testing::TempDir()) + "ninedot_media_" +
                                      testing::UnitTest::GetInstance()->current_test_info()->name();
    const std::pair<const char*, int> nodes[] = {
        {"video0", 0}, {"video1", 1}, {"v4l-subdev0", 2}, {"v4l-subdev1", 3}, {"v4l-subdev2", 4}};
    for (const auto& [name, minor] : nodes) {
      std::filesystem::create_directories(folders.video + "/" + name);
      std::ofstream(folders.video + "/" + name + "/dev") << "81:" << minor << "\n";
    }
    std::ofstream(folders.devices + "/media0") << "node";
  }
  ~FakeMediaKernel() { std::filesystem::remove_all(folders.devices); }

  // What there is.
  FakeVideoKernel video;
  FakeSensor sensor;
  SystemFolders folders;
  bool is_sensor_there = true, has_second = false;
  std::uint32_t sensor_link = MEDIA_LNK_FL_ENABLED | MEDIA_LNK_FL_IMMUTABLE, second_link = 0;
  std::map<unsigned long, int> refusals;                           // of media and sub-devices: request -> errno
  std::function<void(v4l2_mbus_framefmt&, int fd)> change_format;  // what a driver makes of a format
  int grows = 0;                                                   // so often the graph grows between two questions
  // What was done, in order, and what came of it.
  std::vector<std::string> done;
  std::uint32_t code = 0;
  v4l2_rect crop{};
  v4l2_mbus_framefmt at_receiver{};
  int width = 0, height = 0;
  std::map<std::uint32_t, v4l2_queryctrl> controls;
  std::map<std::uint32_t, int> values;
  int open_nodes = 0;
  int exposure_with_power = 0;  // what the driver cuts it to when it starts; 0: it does not

  int open(const char* path) noexcept override {
    const std::string name = std::filesystem::path(path).filename();
    const std::map<std::string, int> own{{"media0", kMediaFd},
                                         {"v4l-subdev0", kSensorFd},
                                         {"v4l-subdev1", kReceiverFd},
                                         {"v4l-subdev2", kSecondFd},
                                         {"video1", kEmbeddedFd}};
    if (const auto found = own.find(name); found != own.end()) {
      if (const auto refused = open_errors.find(name); refused != open_errors.end()) return -refused->second;
      ++open_nodes;
      return found->second;
    }
    return video.open(path);
  }
  std::map<std::string, int> open_errors;
  void close(int fd) noexcept override {
    if (fd >= kMediaFd)
      --open_nodes;
    else
      video.close(fd);
  }
  void* map(int fd, std::size_t bytes, std::uint32_t offset) noexcept override { return video.map(fd, bytes, offset); }
  void unmap(void* memory, std::size_t bytes) noexcept override { video.unmap(memory, bytes); }
  int wait(int fd, MonoTime deadline) noexcept override { return video.wait(fd, deadline); }
  int ioctl(int fd, unsigned long request, void* argument) noexcept override {
    if (fd < kMediaFd) {
      // As unicam does: it starts only what fits.
      if (request == VIDIOC_STREAMON && !fits()) return -EPIPE;
      if (request == VIDIOC_STREAMON && exposure_with_power != 0) values[V4L2_CID_EXPOSURE] = exposure_with_power;
      return video.ioctl(fd, request, argument);
    }
    if (const auto refused = refusals.find(request); refused != refusals.end()) return -refused->second;
    if (fd == kMediaFd) return answer_media(request, argument);
    if (fd == kEmbeddedFd) return answer_embedded(request, argument);
    return answer_subdevice(fd, request, argument);
  }
  /// Whether the receiver was told what the sensor gives.
  bool fits() const {
    return (sensor_link & MEDIA_LNK_FL_ENABLED) != 0 && at_receiver.code == code &&
           static_cast<int>(at_receiver.width) == width && static_cast<int>(at_receiver.height) == height;
  }

  void set_range(std::uint32_t id, int minimum, int maximum, int usual, std::uint32_t flags = 0) {
    v4l2_queryctrl& control = controls[id];
    control = {};
    control.id = id, control.minimum = minimum, control.maximum = maximum, control.default_value = usual;
    control.step = 1, control.type = V4L2_CTRL_TYPE_INTEGER, control.flags = flags;
    std::strcpy(reinterpret_cast<char*>(control.name), "A control");
    values[id] = std::clamp(values.contains(id) ? values[id] : usual, minimum, maximum);
  }

 private:
  template <typename T>
  static T& as(void* argument) {
    return *static_cast<T*>(argument);
  }
  void limit_exposure() {
    const int lines = height + values[V4L2_CID_VBLANK] - sensor.exposure_margin;
    // The kernel refuses a range without its default in it, and ov9282.c, without power, says nothing of that.
    if (sensor.exposure_max == 0 && lines < sensor.exposure) return;
    set_range(V4L2_CID_EXPOSURE, 1, sensor.exposure_max != 0 ? sensor.exposure_max : lines, sensor.exposure);
  }
  void select(const FakeSensor::Mode& mode) {
    width = mode.width, height = mode.height;
    crop = sensor.bounds;
    set_range(V4L2_CID_HBLANK, mode.hblank, sensor.hblank_is_read_only ? mode.hblank : 0x7fff - width, mode.hblank,
              sensor.hblank_is_read_only ? V4L2_CTRL_FLAG_READ_ONLY : 0);
    set_range(V4L2_CID_VBLANK, mode.vblank_min, mode.vblank_max, mode.vblank_default);
    set_range(V4L2_CID_ANALOGUE_GAIN, sensor.gain_min, sensor.gain_max, sensor.gain);
    limit_exposure();
  }

  template <typename T>
  static int give(std::uint64_t address, std::uint32_t count, const std::vector<T>& list) {
    if (address == 0) return 0;
    if (count < list.size()) return -ENOSPC;
    std::ranges::copy(list, reinterpret_cast<T*>(static_cast<std::uintptr_t>(address)));
    return 0;
  }
  int topology(media_v2_topology& asked) {
    std::vector<media_v2_entity> entities;
    std::vector<media_v2_interface> interfaces;
    std::vector<media_v2_pad> pads;
    std::vector<media_v2_link> links;
    const auto add = [&](std::uint32_t id, const std::string& name, std::uint32_t function, std::uint32_t minor,
                         const std::vector<std::uint32_t>& pad_flags) {
      media_v2_entity& entity = entities.emplace_back();
      entity.id = id, entity.function = function;
      std::strcpy(entity.name, name.c_str());
      media_v2_interface& interface = interfaces.emplace_back();
      interface.id = 100 + id, interface.devnode = {81, minor};
      links.push_back({200 + id, 100 + id, id, MEDIA_LNK_FL_INTERFACE_LINK | MEDIA_LNK_FL_ENABLED, {}});
      for (std::uint32_t i = 0; i < pad_flags.size(); ++i) pads.push_back({10 * id + i, id, pad_flags[i], i, {}});
    };
    const std::uint32_t in = MEDIA_PAD_FL_SINK, out = MEDIA_PAD_FL_SOURCE;
    const std::uint32_t fixed = MEDIA_LNK_FL_ENABLED | MEDIA_LNK_FL_IMMUTABLE;
    if (is_sensor_there) add(kSensor, sensor.name, MEDIA_ENT_F_CAM_SENSOR, 2, {out});
    add(kReceiver, "unicam", MEDIA_ENT_F_VID_IF_BRIDGE, 3, {in, out, out});
    add(kEmbedded, "unicam-embedded", MEDIA_ENT_F_IO_V4L, 1, {in});
    add(kImage, "unicam-image", MEDIA_ENT_F_IO_V4L, 0, {in});
    links.push_back({302, 10 * kReceiver + 2, 10 * kEmbedded, fixed, {}});
    links.push_back({301, 10 * kReceiver + 1, 10 * kImage, fixed, {}});
    if (is_sensor_there) links.push_back({300, 10 * kSensor, 10 * kReceiver, sensor_link, {}});
    if (has_second) add(kSecond, "ov9281 11-0060", MEDIA_ENT_F_CAM_SENSOR, 4, {out});
    if (has_second) links.push_back({303, 10 * kSecond, 10 * kReceiver, second_link, {}});
    if (asked.ptr_entities != 0 && grows > 0) --grows, asked.num_entities = 1;
    const int results[] = {give(asked.ptr_entities, asked.num_entities, entities),
                           give(asked.ptr_interfaces, asked.num_interfaces, interfaces),
                           give(asked.ptr_pads, asked.num_pads, pads), give(asked.ptr_links, asked.num_links, links)};
    asked.num_entities = static_cast<__u32>(entities.size());
    asked.num_interfaces = static_cast<__u32>(interfaces.size());
    asked.num_pads = static_cast<__u32>(pads.size());
    asked.num_links = static_cast<__u32>(links.size());
    return *std::ranges::min_element(results);
  }
  int answer_media(unsigned long request, void* argument) {
    if (request == MEDIA_IOC_G_TOPOLOGY) return topology(as<media_v2_topology>(argument));
    if (request == MEDIA_IOC_DEVICE_INFO) {
      std::strcpy(as<media_device_info>(argument).driver, "unicam");
      std::strcpy(as<media_device_info>(argument).bus_info, "platform:fe801000.csi");
      return 0;
    }
    if (request != MEDIA_IOC_SETUP_LINK) return -ENOTTY;
    const auto& link = as<media_link_desc>(argument);
    std::uint32_t& flags = link.source.entity == kSensor ? sensor_link : second_link;
    if ((flags & MEDIA_LNK_FL_IMMUTABLE) != 0) return -EINVAL;
    flags = link.flags;
    done.push_back(fmt::format("link {}:{} -> {}:{} {}", link.source.entity, link.source.index, link.sink.entity,
                               link.sink.index, (link.flags & MEDIA_LNK_FL_ENABLED) != 0 ? "on" : "off"));
    return 0;
  }
  int answer_embedded(unsigned long request, void* argument) {
    if (request != VIDIOC_QUERYCAP) return -ENOTTY;
    as<v4l2_capability>(argument).capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_IO_MC;
    return 0;
  }
  int answer_subdevice(int fd, unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_SUBDEV_ENUM_MBUS_CODE: {
        auto& asked = as<v4l2_subdev_mbus_code_enum>(argument);
        if (asked.index >= sensor.codes.size()) return -EINVAL;
        asked.code = sensor.codes[asked.index];
        return 0;
      }
      case VIDIOC_SUBDEV_ENUM_FRAME_SIZE: {
        auto& asked = as<v4l2_subdev_frame_size_enum>(argument);
        if (asked.index >= sensor.modes.size()) return -EINVAL;
        asked.min_width = asked.max_width = static_cast<__u32>(sensor.modes[asked.index].width);
        asked.min_height = asked.max_height = static_cast<__u32>(sensor.modes[asked.index].height);
        return 0;
      }
      case VIDIOC_SUBDEV_S_FMT:
        return set_format(fd, as<v4l2_subdev_format>(argument));
      case VIDIOC_SUBDEV_G_FMT:
        as<v4l2_subdev_format>(argument).format = sensor_format();
        return 0;
      case VIDIOC_SUBDEV_G_SELECTION:
        as<v4l2_subdev_selection>(argument).r =
            as<v4l2_subdev_selection>(argument).target == V4L2_SEL_TGT_CROP ? crop : sensor.bounds;
        return 0;
      case VIDIOC_SUBDEV_S_SELECTION:
        return set_crop(as<v4l2_subdev_selection>(argument));
      default:
        return fd == kSensorFd ? control(request, argument) : -ENOTTY;
    }
  }
  v4l2_mbus_framefmt sensor_format() const {
    v4l2_mbus_framefmt format{};
    format.code = code, format.width = static_cast<__u32>(width), format.height = static_cast<__u32>(height);
    return format;
  }
  int set_crop(v4l2_subdev_selection& asked) {
    if (!sensor.can_crop) return -ENOTTY;
    asked.r.width = (std::max(asked.r.width, 80U) + 3) & ~3U;
    asked.r.height = (std::max(asked.r.height, 4U) + 3) & ~3U;
    if (asked.which == V4L2_SUBDEV_FORMAT_TRY) return 0;
    if (asked.r.width != crop.width || asked.r.height != crop.height)
      width = static_cast<int>(asked.r.width), height = static_cast<int>(asked.r.height);
    crop = asked.r;
    done.push_back(fmt::format("crop {}x{} at {},{}", crop.width, crop.height, crop.left, crop.top));
    return 0;
  }
  int set_format(int fd, v4l2_subdev_format& asked) {
    v4l2_mbus_framefmt& format = asked.format;
    if (change_format) change_format(format, fd);
    done.push_back(fmt::format("{}:{} {:#x} {}x{}", fd == kSensorFd ? "sensor" : "receiver", asked.pad, format.code,
                               format.width, format.height));
    if (fd == kReceiverFd) {
      if (asked.pad == 0) at_receiver = format;
      format = at_receiver;
      return 0;
    }
    const bool is_cut = crop.width != sensor.bounds.width || crop.height != sensor.bounds.height;
    if (std::ranges::find(sensor.codes, format.code) != sensor.codes.end()) code = format.code;
    if (!is_cut) {
      const auto distance = [&](const FakeSensor::Mode& mode) {
        return std::abs(mode.width - static_cast<int>(format.width)) +
               std::abs(mode.height - static_cast<int>(format.height));
      };
      select(*std::ranges::min_element(sensor.modes, {}, distance));
    }
    format = sensor_format();
    return 0;
  }
  int control(unsigned long request, void* argument) {
    if (request == VIDIOC_G_EXT_CTRLS) {
      v4l2_ext_control& asked = *as<v4l2_ext_controls>(argument).controls;
      if (asked.id != V4L2_CID_PIXEL_RATE || sensor.pixel_rate.empty()) return -EINVAL;
      asked.value64 = sensor.pixel_rate.at(code);
      return 0;
    }
    if (request == VIDIOC_QUERYCTRL) {
      auto& asked = as<v4l2_queryctrl>(argument);
      const bool next = (asked.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
      const std::uint32_t id = asked.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
      const auto found = next ? controls.upper_bound(id) : controls.find(id);
      if (found == controls.end()) return -EINVAL;
      asked = found->second;
      return 0;
    }
    if (request != VIDIOC_G_CTRL && request != VIDIOC_S_CTRL) return -ENOTTY;
    auto& asked = as<v4l2_control>(argument);
    if (!controls.contains(asked.id)) return -EINVAL;
    const v4l2_queryctrl& range = controls[asked.id];
    if (request == VIDIOC_S_CTRL) {
      if ((range.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0) return -EACCES;
      values[asked.id] = std::clamp(asked.value, range.minimum, range.maximum);
      const std::map<std::uint32_t, const char*> names{{V4L2_CID_HBLANK, "hblank"},
                                                       {V4L2_CID_VBLANK, "vblank"},
                                                       {V4L2_CID_EXPOSURE, "exposure"},
                                                       {V4L2_CID_ANALOGUE_GAIN, "gain"},
                                                       {V4L2_CID_EXPOSURE_AUTO, "automatic"}};
      done.push_back(fmt::format("{} {}", names.at(asked.id), asked.value));
      if (asked.id == V4L2_CID_VBLANK) limit_exposure();
    }
    asked.value = values[asked.id];
    return 0;
  }
};

}  // namespace ninedot
