// Order matters: a crop decides which sizes there are, a size decides the blanking's range, and blanking that of the
// exposure (v4l2_controls.cpp).
#include "drivers/camera/media_sensor.h"

#include <fmt/format.h>
#include <linux/media-bus-format.h>
#include <linux/media.h>
#include <linux/v4l2-subdev.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/camera/control_access.h"
#include "drivers/camera/open_failure.h"

namespace ninedot {
namespace {

// A driver that goes on answering must not keep us for ever.
constexpr std::uint32_t kMaxCodes = 64;
constexpr std::uint32_t kMaxSizes = 64;
/// A rate this near is the one asked for, and a row time likewise: one line of 1000 is 0.1 %.
constexpr double kSame = 0.01;
/// A crop begins on whole cells of a mosaic, and where sensors like it: imx296.c aligns to 4.
constexpr int kCropStep = 4;
/// Whether a sensor crops shows in so much less of it.
constexpr int kCropProbe_px = 32;

struct BusFormat {
  std::uint32_t code;
  std::string_view name;
};
/// Packed or not is the receiver's choice: the bus is the same.
constexpr std::array kBusFormats{
    BusFormat{MEDIA_BUS_FMT_Y8_1X8, "GREY"},         BusFormat{MEDIA_BUS_FMT_Y10_1X10, "Y10"},
    BusFormat{MEDIA_BUS_FMT_Y12_1X12, "Y12"},        BusFormat{MEDIA_BUS_FMT_SRGGB8_1X8, "RGGB"},
    BusFormat{MEDIA_BUS_FMT_SBGGR8_1X8, "BGGR"},     BusFormat{MEDIA_BUS_FMT_SGRBG8_1X8, "GRBG"},
    BusFormat{MEDIA_BUS_FMT_SGBRG8_1X8, "GBRG"},     BusFormat{MEDIA_BUS_FMT_SRGGB10_1X10, "RGGB10"},
    BusFormat{MEDIA_BUS_FMT_SBGGR10_1X10, "BGGR10"}, BusFormat{MEDIA_BUS_FMT_SGRBG10_1X10, "GRBG10"},
    BusFormat{MEDIA_BUS_FMT_SGBRG10_1X10, "GBRG10"}, BusFormat{MEDIA_BUS_FMT_SRGGB12_1X12, "RGGB12"},
    BusFormat{MEDIA_BUS_FMT_SBGGR12_1X12, "BGGR12"}, BusFormat{MEDIA_BUS_FMT_SGRBG12_1X12, "GRBG12"},
    BusFormat{MEDIA_BUS_FMT_SGBRG12_1X12, "GBRG12"},
};

std::string code_text(std::uint32_t code) {
  const auto found = std::ranges::find(kBusFormats, code, &BusFormat::code);
  return found == kBusFormats.end() ? fmt::format("bus format {:#06x}", code) : std::string(found->name);
}

/// Of these the whole picture is exposed at once (OmniVision's and Sony's data sheets); no driver tells it.
constexpr std::array<std::string_view, 3> kGlobalShutters{"ov9281", "ov9282", "imx296"};
/// Its driver tells the blanking of the whole width, 1456, whatever the crop or binning, and keeps the line as long
/// (imx296.c: HMAX is always 1100 at 74.25 MHz).
constexpr std::string_view kLineOfWholeWidth = "imx296";

v4l2_subdev_selection selection_of(std::uint32_t target) {
  v4l2_subdev_selection selection{};
  selection.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  selection.target = target;
  return selection;
}

v4l2_rect middle_of(const v4l2_rect& bounds, int width_px, int height_px) {
  const auto start = [](int from, int room) { return from + room / 2 / kCropStep * kCropStep; };
  return {start(bounds.left, static_cast<int>(bounds.width) - width_px),
          start(bounds.top, static_cast<int>(bounds.height) - height_px), static_cast<__u32>(width_px),
          static_cast<__u32>(height_px)};
}

}  // namespace

std::uint32_t bus_code_of(const PixelFormat& format) noexcept {
  const std::string_view name =
      format.name.ends_with('P') ? format.name.substr(0, format.name.size() - 1) : format.name;
  const auto found = std::ranges::find(kBusFormats, name, &BusFormat::name);
  return found == kBusFormats.end() ? 0 : found->code;
}

MediaSensor::MediaSensor(VideoKernel& kernel, SensorRoute route, std::string device)
    : kernel_(kernel), route_(std::move(route)), device_(std::move(device)) {
  fd_ = kernel_.open(route_.sensor.node.c_str());
  if (fd_ < 0) throw CameraRefused(describe_open_failure(route_.sensor.node, -fd_), -fd_);
}

MediaSensor::~MediaSensor() {
  if (fd_ >= 0) kernel_.close(fd_);
}

void MediaSensor::refuse(const std::string& what, int error) const {
  throw CameraRefused(fmt::format("{}: {}", device_, what), error);
}

std::vector<std::uint32_t> MediaSensor::codes() const {
  std::vector<std::uint32_t> codes;
  for (std::uint32_t i = 0; i < kMaxCodes; ++i) {
    v4l2_subdev_mbus_code_enum code{};
    code.pad = route_.links.front().source_pad_index;
    code.index = i;
    code.which = V4L2_SUBDEV_FORMAT_ACTIVE;
    if (kernel_.ioctl(fd_, VIDIOC_SUBDEV_ENUM_MBUS_CODE, &code) < 0) break;
    codes.push_back(code.code);
  }
  return codes;
}

std::vector<OfferedSize> MediaSensor::sizes(std::uint32_t code) const {
  std::vector<OfferedSize> sizes;
  for (std::uint32_t i = 0; i < kMaxSizes; ++i) {
    v4l2_subdev_frame_size_enum size{};
    size.pad = route_.links.front().source_pad_index;
    size.index = i;
    size.code = code;
    size.which = V4L2_SUBDEV_FORMAT_ACTIVE;
    if (kernel_.ioctl(fd_, VIDIOC_SUBDEV_ENUM_FRAME_SIZE, &size) < 0) break;
    OfferedSize& offered = sizes.emplace_back();
    offered.width_px = static_cast<int>(size.max_width), offered.height_px = static_cast<int>(size.max_height);
    offered.least_width_px = static_cast<int>(size.min_width),
    offered.least_height_px = static_cast<int>(size.min_height);
  }
  return sizes;
}

/// Asked as a trial, which changes nothing.
bool MediaSensor::can_crop_to(int width_px, int height_px) const {
  v4l2_subdev_selection bounds = selection_of(V4L2_SEL_TGT_CROP_BOUNDS);
  if (kernel_.ioctl(fd_, VIDIOC_SUBDEV_G_SELECTION, &bounds) < 0 || width_px > static_cast<int>(bounds.r.width) ||
      height_px > static_cast<int>(bounds.r.height))
    return false;
  v4l2_subdev_selection trial = selection_of(V4L2_SEL_TGT_CROP);
  trial.which = V4L2_SUBDEV_FORMAT_TRY;
  trial.r = middle_of(bounds.r, width_px, height_px);
  return kernel_.ioctl(fd_, VIDIOC_SUBDEV_S_SELECTION, &trial) >= 0 && static_cast<int>(trial.r.width) == width_px &&
         static_cast<int>(trial.r.height) == height_px;
}

std::vector<OfferedFormat> MediaSensor::offers(const std::vector<OfferedFormat>& of_node,
                                               const CameraRequest& request) const {
  const std::vector<std::uint32_t> own = codes();
  const bool can_crop = can_crop_to(request.width_px, request.height_px);
  std::vector<OfferedFormat> offers;
  for (const OfferedFormat& offer : of_node) {
    const std::uint32_t code = offer.known == nullptr ? 0 : bus_code_of(*offer.known);
    if (code == 0 || std::ranges::find(own, code) == own.end()) continue;
    offers.push_back({offer.fourcc, offer.known, sizes(code)});
    std::vector<OfferedSize>& listed = offers.back().sizes;
    const auto fits = [&](const OfferedSize& size) { return size.contains(request.width_px, request.height_px); };
    if (can_crop && std::ranges::none_of(listed, fits))
      listed.push_back({request.width_px, request.height_px, request.width_px, request.height_px, 1, 1, 0});
  }
  return offers;
}

/// A size that the sensor lists is made of the whole of it; any other one is cut out of the middle.
void MediaSensor::crop_for(std::uint32_t code, int width_px, int height_px) {
  const std::vector<OfferedSize> listed = sizes(code);
  const auto fits = [&](const OfferedSize& size) { return size.contains(width_px, height_px); };
  const bool is_whole = std::ranges::any_of(listed, fits);
  v4l2_subdev_selection bounds = selection_of(V4L2_SEL_TGT_CROP_BOUNDS);
  if (kernel_.ioctl(fd_, VIDIOC_SUBDEV_G_SELECTION, &bounds) < 0) return;
  v4l2_subdev_selection crop = selection_of(V4L2_SEL_TGT_CROP);
  crop.r = is_whole ? bounds.r : middle_of(bounds.r, width_px, height_px);
  const int error = kernel_.ioctl(fd_, VIDIOC_SUBDEV_S_SELECTION, &crop);
  // Most sensors tell what each size shows and let nobody choose.
  if (error < 0 && !is_whole) refuse(fmt::format("the sensor refused the crop: {}", std::strerror(-error)), -error);
}

void MediaSensor::set_pad(int fd, std::uint32_t entity_id, std::uint32_t pad_index, const Frame& frame) const {
  v4l2_subdev_format format{};
  format.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  format.pad = pad_index;
  format.format.code = frame.code;
  format.format.width = static_cast<__u32>(frame.width_px);
  format.format.height = static_cast<__u32>(frame.height_px);
  format.format.field = V4L2_FIELD_NONE;
  const std::string& name = route_.graph.entity(entity_id).name;
  const std::string asked = fmt::format("{} {}x{}", code_text(frame.code), frame.width_px, frame.height_px);
  if (const int error = kernel_.ioctl(fd, VIDIOC_SUBDEV_S_FMT, &format); error < 0)
    refuse(error == -EBUSY ? fmt::format("'{}' is busy: stop the program that uses the camera", name)
                           : fmt::format("'{}' refused {}: {}", name, asked, std::strerror(-error)),
           -error);
  const v4l2_mbus_framefmt& got = format.format;
  if (got.code != frame.code || static_cast<int>(got.width) != frame.width_px ||
      static_cast<int>(got.height) != frame.height_px)
    refuse(
        fmt::format("asked for {}, '{}' makes {} {}x{} of it", asked, name, code_text(got.code), got.width, got.height),
        EINVAL);
}

/// The kernel starts nothing while the two ends of any link that is on differ, also where the sensor feeds another node
/// beside ours. Refusals don't count: starting says what is wrong.
void MediaSensor::match_neighbours(const Frame& frame) const {
  for (const MediaLink& link : route_.graph.links) {
    const bool is_on = (link.flags & MEDIA_LNK_FL_ENABLED) != 0;
    const std::string& node = route_.graph.entity(link.sink_id).node;
    if (link.source_id != route_.sensor.id || !is_on || link == route_.links.front() || node.empty()) continue;
    const int fd = kernel_.open(node.c_str());
    if (fd < 0) continue;
    v4l2_subdev_format format{};
    format.which = V4L2_SUBDEV_FORMAT_ACTIVE;
    format.pad = link.sink_pad_index;
    format.format.code = frame.code;
    format.format.width = static_cast<__u32>(frame.width_px);
    format.format.height = static_cast<__u32>(frame.height_px);
    kernel_.ioctl(fd, VIDIOC_SUBDEV_S_FMT, &format);
    kernel_.close(fd);
  }
}

void MediaSensor::set_path(const PixelFormat& format, int width_px, int height_px) {
  const Frame frame{bus_code_of(format), width_px, height_px};
  enable_links(kernel_, route_, device_);
  crop_for(frame.code, width_px, height_px);
  set_pad(fd_, route_.sensor.id, route_.links.front().source_pad_index, frame);
  match_neighbours(frame);
  for (std::size_t i = 0; i + 1 < route_.links.size(); ++i) {
    const MediaLink &in = route_.links[i], &out = route_.links[i + 1];
    const MediaEntity& between = route_.graph.entity(in.sink_id);
    if (between.node.empty()) continue;  // the driver of the video node sets it
    const int fd = kernel_.open(between.node.c_str());
    if (fd < 0) throw CameraRefused(describe_open_failure(between.node, -fd), -fd);
    try {
      set_pad(fd, between.id, in.sink_pad_index, frame);
      set_pad(fd, between.id, out.source_pad_index, frame);
    } catch (...) {
      kernel_.close(fd);
      throw;
    }
    kernel_.close(fd);
  }
  width_px_ = width_px, height_px_ = height_px;
}

int MediaSensor::line_width_px(int width_px) const {
  if (!route_.sensor.name.starts_with(kLineOfWholeWidth)) return width_px;
  v4l2_subdev_selection whole = selection_of(V4L2_SEL_TGT_NATIVE_SIZE);
  return kernel_.ioctl(fd_, VIDIOC_SUBDEV_G_SELECTION, &whole) < 0 ? width_px : static_cast<int>(whole.r.width);
}

SensorTiming MediaSensor::read_timing(int width, int height) const {
  const auto rate = read_long_control(kernel_, fd_, V4L2_CID_PIXEL_RATE);
  const auto beside = read_control(kernel_, fd_, V4L2_CID_HBLANK), below = read_control(kernel_, fd_, V4L2_CID_VBLANK);
  if (!rate || !beside || !below) return {};
  return {static_cast<double>(*rate), line_width_px(width) + *beside, height + *below};
}

std::string MediaSensor::set_rate(double rate_hz) {
  const Controls controls(kernel_, fd_, device_);
  // Somebody may have made the lines longer; as short as the driver has them is what its limits are made for.
  const auto beside = controls.find(V4L2_CID_HBLANK);
  if (beside && (beside->flags & V4L2_CTRL_FLAG_READ_ONLY) == 0 && controls.read(beside->id) != beside->default_value)
    controls.write(*beside, beside->default_value, "horizontal blanking");
  timing_ = read_timing(width_px_, height_px_);
  const auto below = controls.find(V4L2_CID_VBLANK);
  if (!timing_.is_known() || !below) return set_interval(rate_hz);
  const double lines = timing_.lines_in(std::chrono::nanoseconds(std::llround(1e9 / rate_hz)));
  const int blank = controls.write(*below, clamp_to(*below, lines - height_px_), "vertical blanking");
  timing_.frame_lines = height_px_ + blank;
  period_ = timing_.frame_period();
  const double got_hz = 1e9 / static_cast<double>(period_->count());
  return std::abs(got_hz - rate_hz) <= kSame * rate_hz ? "" : fmt::format(" (asked {:g})", rate_hz);
}

/// Of sensors without blanking controls.
std::string MediaSensor::set_interval(double rate_hz) {
  v4l2_subdev_frame_interval interval{};
  interval.pad = route_.links.front().source_pad_index;
  interval.interval = {1000, static_cast<__u32>(std::lround(rate_hz * 1000))};
  period_.reset();
  if (kernel_.ioctl(fd_, VIDIOC_SUBDEV_S_FRAME_INTERVAL, &interval) < 0 || interval.interval.numerator == 0 ||
      interval.interval.denominator == 0)
    return " (assumed: this sensor's rate can't be set)";
  const double period_s = static_cast<double>(interval.interval.numerator) / interval.interval.denominator;
  period_ = std::chrono::nanoseconds(std::llround(1e9 * period_s));
  return std::abs(1 / period_s - rate_hz) <= kSame * rate_hz ? "" : fmt::format(" (asked {:g})", rate_hz);
}

std::string MediaSensor::describe_now() const {
  v4l2_subdev_format format{};
  format.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  format.pad = route_.links.front().source_pad_index;
  if (kernel_.ioctl(fd_, VIDIOC_SUBDEV_G_FMT, &format) < 0) return {};
  const int width = static_cast<int>(format.format.width), height = static_cast<int>(format.format.height);
  std::string text = fmt::format("{} {}x{}", code_text(format.format.code), width, height);
  SensorTiming timing = read_timing(width, height);
  if (const auto below = Controls(kernel_, fd_, device_).find(V4L2_CID_VBLANK); below && timing.is_known()) {
    const auto rate_with = [&](int blank) {
      timing.frame_lines = height + blank;
      return 1e9 / static_cast<double>(timing.frame_period().count());
    };
    text += fmt::format(", {:.3g} to {:.4g} Hz, line time {:.4g} us", rate_with(below->maximum),
                        rate_with(below->minimum), static_cast<double>(timing.line_time().count()) / 1e3);
  }
  v4l2_subdev_selection bounds = selection_of(V4L2_SEL_TGT_CROP_BOUNDS);
  if (kernel_.ioctl(fd_, VIDIOC_SUBDEV_G_SELECTION, &bounds) < 0) return text;
  const int less_width = static_cast<int>(bounds.r.width) - kCropProbe_px;
  const int less_height = static_cast<int>(bounds.r.height) - kCropProbe_px;
  if (can_crop_to(less_width, less_height))
    text += fmt::format(", cuts smaller sizes out of {}x{}", bounds.r.width, bounds.r.height);
  return text;
}

std::string MediaSensor::describe_shutter(std::chrono::nanoseconds row_time) const {
  if (!timing_.is_known()) return {};
  const double line_us = static_cast<double>(timing_.line_time().count()) / 1e3;
  const double row_us = static_cast<double>(row_time.count()) / 1e3;
  const std::string line = fmt::format("line time {:.4g} us", line_us);
  const auto is_it = [&](std::string_view name) { return route_.sensor.name.starts_with(name); };
  if (std::ranges::any_of(kGlobalShutters, is_it))
    return row_us == 0
               ? "global shutter, " + line
               : fmt::format("{}, but this shutter is global: camera.row_time_us should be 0, not {:g}", line, row_us);
  if (row_us == 0) return fmt::format("{0} (camera.row_time_us = {1:.4g} if its shutter rolls)", line, line_us);
  if (std::abs(row_us - line_us) <= kSame * line_us) return line;
  return fmt::format("{}, but camera.row_time_us = {:g}", line, row_us);
}

}  // namespace ninedot
