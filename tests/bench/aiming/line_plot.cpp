#include "tests/bench/aiming/line_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ninedot::bench {
namespace {

constexpr double kLeft_px = 64, kRight_px = 600, kTop_px = 28, kBottom_px = 270;

struct Axes {
  double x_end, y_end;
  double x_px(double x) const { return kLeft_px + x / x_end * (kRight_px - kLeft_px); }
  double y_px(double y) const { return kBottom_px - std::min(y, y_end) / y_end * (kBottom_px - kTop_px); }
};

/// 1, 2 or 5 times a power of ten, for about five marks.
double step_for(double end) {
  const double rough = end / 5, decade = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= rough * 0.999) return factor * decade;
  return 10 * decade;
}

std::string grid(const LinePlot& plot, const Axes& axes) {
  std::string svg;
  for (const auto& [from, to] : plot.grey)
    svg += fmt::format("<rect x='{:.1f}' y='{}' width='{:.1f}' height='{}' fill='#eeeeee'/>\n", axes.x_px(from),
                       kTop_px, axes.x_px(to) - axes.x_px(from), kBottom_px - kTop_px);
  for (int i = 0; i * step_for(axes.y_end) <= axes.y_end * 1.0001; ++i) {
    const double y = i * step_for(axes.y_end);
    svg += fmt::format("<line x1='{}' y1='{:.1f}' x2='{}' y2='{:.1f}' stroke='#dddddd'/>\n", kLeft_px, axes.y_px(y),
                       kRight_px, axes.y_px(y));
    svg += fmt::format("<text x='{}' y='{:.1f}' text-anchor='end'>{:g}</text>\n", kLeft_px - 8, axes.y_px(y) + 4, y);
  }
  for (int i = 0; i * step_for(axes.x_end) <= axes.x_end * 1.0001; ++i) {
    const double x = i * step_for(axes.x_end);
    svg += fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle'>{:g}</text>\n", axes.x_px(x), kBottom_px + 19, x);
  }
  svg += fmt::format("<path d='M{0} {1}V{2}H{3}' fill='none' stroke='#444444'/>\n", kLeft_px, kTop_px, kBottom_px,
                     kRight_px);
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>\n", (kLeft_px + kRight_px) / 2,
                     kBottom_px + 38, plot.x_label);
  svg += fmt::format("<text transform='translate(16 {}) rotate(-90)' text-anchor='middle'>{}</text>\n",
                     (kTop_px + kBottom_px) / 2, plot.y_label);
  return svg;
}

}  // namespace

std::string drawn(const LinePlot& plot) {
  Axes axes{0, plot.y_end};
  for (const PlotLine& line : plot.lines)
    for (const auto& [x, y] : line.points) axes.x_end = std::max(axes.x_end, x);
  std::string svg =
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 620 320' width='620' height='320' font-family='sans-serif' "
      "font-size='12' fill='#222222'>\n<rect width='620' height='320' fill='white'/>\n";
  svg += grid(plot, axes);
  double legend_px = kLeft_px + 8;
  for (const PlotLine& line : plot.lines) {
    std::string path;
    for (const auto& [x, y] : line.points)
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", axes.x_px(x), axes.y_px(y));
    svg += fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='2'/>\n", path, line.colour);
    svg += fmt::format("<path d='M{} 12h24' stroke='{}' stroke-width='2'/>\n<text x='{}' y='16'>{}</text>\n", legend_px,
                       line.colour, legend_px + 30, line.name);
    legend_px += 60 + 7.0 * static_cast<double>(line.name.size());
  }
  return svg + "</svg>\n";
}

}  // namespace ninedot::bench
