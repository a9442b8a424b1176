#include "drivers/camera/v4l2_formats.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>

namespace ninedot {
namespace {

// A driver that goes on answering must not keep us for ever.
constexpr std::uint32_t kMaxFormats = 256;
constexpr std::uint32_t kMaxSizes = 128;
constexpr std::uint32_t kMaxIntervals = 64;
/// 29.97 is 30.
constexpr double kEnoughRate = 0.98;

double rate_of(const v4l2_fract& interval) noexcept {
  return interval.numerator == 0 ? 0 : static_cast<double>(interval.denominator) / interval.numerator;
}

double read_max_rate(VideoKernel& kernel, int fd, std::uint32_t fourcc, int width_px, int height_px) {
  double max_rate_hz = 0;
  for (std::uint32_t i = 0; i < kMaxIntervals; ++i) {
    v4l2_frmivalenum interval{};
    interval.index = i;
    interval.pixel_format = fourcc;
    interval.width = static_cast<std::uint32_t>(width_px);
    interval.height = static_cast<std::uint32_t>(height_px);
    if (kernel.ioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &interval) < 0) break;
    if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) return rate_of(interval.stepwise.min);
    max_rate_hz = std::max(max_rate_hz, rate_of(interval.discrete));
  }
  return max_rate_hz;
}

OfferedSize size_of(const v4l2_frmsizeenum& size) {
  OfferedSize offered;
  if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
    offered.width_px = offered.least_width_px = static_cast<int>(size.discrete.width);
    offered.height_px = offered.least_height_px = static_cast<int>(size.discrete.height);
    return offered;
  }
  offered.width_px = static_cast<int>(size.stepwise.max_width);
  offered.height_px = static_cast<int>(size.stepwise.max_height);
  offered.least_width_px = static_cast<int>(size.stepwise.min_width);
  offered.least_height_px = static_cast<int>(size.stepwise.min_height);
  offered.width_step_px = std::max(1, static_cast<int>(size.stepwise.step_width));
  offered.height_step_px = std::max(1, static_cast<int>(size.stepwise.step_height));
  return offered;
}

std::vector<OfferedSize> read_sizes(VideoKernel& kernel, int fd, std::uint32_t fourcc) {
  std::vector<OfferedSize> sizes;
  for (std::uint32_t i = 0; i < kMaxSizes; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = fourcc;
    if (kernel.ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &size) < 0) break;
    sizes.push_back(size_of(size));
    sizes.back().max_rate_hz = read_max_rate(kernel, fd, fourcc, sizes.back().width_px, sizes.back().height_px);
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) break;  // one entry says it all
  }
  return sizes;
}

std::string describe_size(const OfferedSize& size) {
  std::string text = fmt::format("{}x{}", size.width_px, size.height_px);
  if (size.least_width_px != size.width_px || size.least_height_px != size.height_px)
    text = fmt::format("{}x{} to {}", size.least_width_px, size.least_height_px, text);
  if (size.max_rate_hz > 0) text += fmt::format(" {:.4g} Hz", size.max_rate_hz);
  return text;
}

/// \return  the highest rate of this format at that size; 0: unknown; -1: not this size
double rate_at(const OfferedFormat& offer, int width_px, int height_px) {
  if (offer.sizes.empty()) return 0;
  double rate_hz = -1;
  for (const OfferedSize& size : offer.sizes)
    if (size.contains(width_px, height_px)) rate_hz = std::max(rate_hz, size.max_rate_hz);
  return rate_hz;
}

std::size_t preference_of(const OfferedFormat& offer) {
  return static_cast<std::size_t>(offer.known - pixel_formats().data());
}

/// Whether `a` serves the request better than `b`.
bool is_better(const OfferedFormat& a, const OfferedFormat& b, const CameraRequest& request) {
  const bool a_jpeg = a.known->layout == PixelLayout::kJpeg, b_jpeg = b.known->layout == PixelLayout::kJpeg;
  if (a_jpeg != b_jpeg) return b_jpeg;
  const double a_rate = rate_at(a, request.width_px, request.height_px);
  const double b_rate = rate_at(b, request.width_px, request.height_px);
  const auto is_enough = [&](double rate_hz) { return rate_hz == 0 || rate_hz >= kEnoughRate * request.rate_hz; };
  if (is_enough(a_rate) != is_enough(b_rate)) return is_enough(a_rate);
  if (!is_enough(a_rate) && a_rate != b_rate) return a_rate > b_rate;
  return preference_of(a) < preference_of(b);
}

}  // namespace

bool OfferedSize::contains(int width, int height) const noexcept {
  return width >= least_width_px && width <= width_px && height >= least_height_px && height <= height_px &&
         (width - least_width_px) % width_step_px == 0 && (height - least_height_px) % height_step_px == 0;
}

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (unsigned i = 0; i < 4; ++i) {
    const auto c = static_cast<char>((fourcc >> (8 * i)) & 0x7FU);
    text += c < ' ' || c > '~' ? '?' : c;
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::vector<OfferedFormat> read_offered_formats(VideoKernel& kernel, int fd) {
  std::vector<OfferedFormat> offers;
  for (std::uint32_t i = 0; i < kMaxFormats; ++i) {
    v4l2_fmtdesc format{};
    format.index = i;
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (kernel.ioctl(fd, VIDIOC_ENUM_FMT, &format) < 0) break;
    offers.push_back({format.pixelformat, find_pixel_format(format.pixelformat), {}});
    offers.back().sizes = read_sizes(kernel, fd, format.pixelformat);
  }
  return offers;
}

std::vector<std::string> describe_offers(const std::vector<OfferedFormat>& offers) {
  std::vector<std::pair<std::string, std::string>> groups;  // sizes, formats
  std::string unreadable;
  const auto add = [](std::string& list, const std::string& name) { list += (list.empty() ? "" : ", ") + name; };
  for (const OfferedFormat& offer : offers) {
    if (offer.known == nullptr) {
      add(unreadable, fourcc_text(offer.fourcc));
      continue;
    }
    std::string sizes;
    for (const OfferedSize& size : offer.sizes) add(sizes, describe_size(size));
    auto group = std::ranges::find(groups, sizes, [](const auto& entry) { return entry.first; });
    if (group == groups.end()) group = groups.insert(groups.end(), {sizes, {}});
    add(group->second, std::string(offer.known->name));
  }
  std::vector<std::string> lines;
  for (const auto& [sizes, names] : groups) lines.push_back(sizes.empty() ? names : fmt::format("{} {}", names, sizes));
  if (!unreadable.empty()) lines.push_back("not readable here: " + unreadable);
  if (lines.empty()) lines.push_back("no format at all");
  return lines;
}

const OfferedFormat* choose_format(const std::vector<OfferedFormat>& offers, const CameraRequest& request) {
  const OfferedFormat* best = nullptr;
  for (const OfferedFormat& offer : offers) {
    if (offer.known == nullptr || rate_at(offer, request.width_px, request.height_px) < 0) continue;
    const bool is_wanted = request.pixel_format == "auto" || offer.known->name == request.pixel_format ||
                           (request.pixel_format == "MJPG" && offer.known->layout == PixelLayout::kJpeg);
    if (is_wanted && (best == nullptr || is_better(offer, *best, request))) best = &offer;
  }
  return best;
}

}  // namespace ninedot
