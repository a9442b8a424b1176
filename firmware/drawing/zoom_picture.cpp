#include "drawing/zoom_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr double kWidth = 400, kHeight = 260, kGap = 70, kMargin = 60, kTop = 58, kBottom = 50;  // CSS px

struct Line {
  const char* colour;
  std::function<double(const DrawnZoom&)> height;  // before it is scaled
};

/// One diagram of what `lines` say of each position.
std::string draw_diagram(const ZoomDrawing& drawing, double left, const char* heading,
                         std::initializer_list<Line> lines, const std::function<std::string(double)>& label) {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const auto* points : {&drawing.calibrated, &drawing.between})
    for (const DrawnZoom& point : *points)
      for (const Line& line : lines)
        lowest = std::min(lowest, line.height(point)), highest = std::max(highest, line.height(point));
  const double range = std::max(highest - lowest, 1e-9);
  const double first = drawing.calibrated.front().zoom, last = drawing.calibrated.back().zoom;
  const auto x = [&](const DrawnZoom& point) { return left + (point.zoom - first) / (last - first) * kWidth; };
  const auto y = [&](double height) { return kTop + (highest - height) / range * kHeight; };
  std::string text;
  for (const Line& line : lines) {
    std::string path;
    for (const DrawnZoom& point : drawing.between)
      path += fmt::format("{:.1f},{:.1f} ", x(point), y(line.height(point)));
    if (!path.empty())
      text += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\"/>\n", path, line.colour);
    for (const DrawnZoom& point : drawing.calibrated)
      text += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"/>\n", x(point),
                          y(line.height(point)), line.colour);
  }
  for (const double height : {lowest, highest})
    text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"12\" text-anchor=\"end\">{}</text>\n", left - 8,
                        y(height) + 4, label(height));
  for (const DrawnZoom* point : {&drawing.calibrated.front(), &drawing.calibrated.back()})
    text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"12\" text-anchor=\"middle\">{}</text>\n",
                        x(*point), kTop + kHeight + 24, point->zoom);
  return text + fmt::format(
                    "<rect x=\"{0:.1f}\" y=\"{1}\" width=\"{2}\" height=\"{3}\" fill=\"none\" stroke=\"#1a1a1a\"/>\n"
                    "<text x=\"{0:.1f}\" y=\"{4}\" font-size=\"13\" font-weight=\"bold\">{5}</text>\n",
                    left, kTop, kWidth, kHeight, kTop - 8, heading);
}

}  // namespace

std::string draw_zoom(const ZoomDrawing& drawing) {
  EXPECTS(drawing.calibrated.size() >= 2);
  const double width = 2 * kMargin + 2 * kWidth + kGap, height = kTop + kHeight + kBottom;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"Helvetica, Arial, sans-serif\" fill=\"#1a1a1a\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"#ffffff\"/>\n<text x=\"{2}\" y=\"24\" font-size=\"15\">{3}</text>\n",
      width, height, kMargin, drawing.title);
  text += draw_diagram(drawing, kMargin, "Focal length over zoom, px, logarithmic",
                       {{"#1d4ed8", [](const DrawnZoom& at) { return std::log(at.fx_px); }}},
                       [](double log_px) { return fmt::format("{:.4g}", std::exp(log_px)); });
  text += draw_diagram(drawing, kMargin + kWidth + kGap, "Centre over zoom, px: x blue, y red, from the first position",
                       {{"#1d4ed8", [&](const DrawnZoom& at) { return at.cx_px - drawing.calibrated.front().cx_px; }},
                        {"#b91c1c", [&](const DrawnZoom& at) { return at.cy_px - drawing.calibrated.front().cy_px; }}},
                       [](double off_px) { return fmt::format("{:+.2f}", off_px); });
  return text + "</svg>\n";
}

}  // namespace ninedot
