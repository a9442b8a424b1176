#include "drivers/servo/visca_zoom_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/startup_error.h"

namespace ninedot {

ViscaZoomTable::ViscaZoomTable(std::span<const ZoomPoint> points) : count_(points.size()) {
  const auto need = [](bool right, const std::string& line) {
    if (!right) throw StartupError(ExitStatus::kWrongUsage, line);
  };
  need(points.size() >= 2 && points.size() <= kMaxPoints,
       fmt::format("a zoom table needs 2 to {} points, not {}", kMaxPoints, points.size()));
  need(points.front().zoom >= 0 && points.back().zoom <= 0xFFFF, "the zoom positions must be 0 to 65535");
  need(points.front().focal_length_mm > 0 && std::isfinite(points.back().focal_length_mm),
       "the focal lengths must be finite and above 0");
  for (std::size_t i = 1; i < points.size(); ++i) {
    need(points[i].zoom > points[i - 1].zoom,
         fmt::format("the zoom positions must rise strictly: number {} does not", i + 1));
    need(points[i].focal_length_mm > points[i - 1].focal_length_mm,
         fmt::format("the focal lengths must rise strictly: number {} does not", i + 1));
  }
  std::ranges::copy(points, points_.begin());
}

double ViscaZoomTable::focal_length_mm_at(int zoom) const noexcept {
  std::size_t i = 1;
  while (i + 1 < count_ && zoom > points_[i].zoom) ++i;
  const ZoomPoint &a = points_[i - 1], &b = points_[i];
  const double part = static_cast<double>(zoom - a.zoom) / (b.zoom - a.zoom);
  return std::lerp(a.focal_length_mm, b.focal_length_mm, std::clamp(part, 0.0, 1.0));
}

}  // namespace ninedot
