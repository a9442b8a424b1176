// A small line plot, drawn by hand: no plotting library is worth a dependency for one kind of picture.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/bench/accuracy_report.h"

namespace ninedot::bench {
namespace {

constexpr double kLeft_px = 64, kRight_px = 590, kTop_px = 24, kBottom_px = 270;

// Of Okabe & Ito's palette, told apart by colour-blind eyes.
constexpr const char *kGrey = "#555555", *kBlue = "#0072B2", *kVermilion = "#D55E00";

struct Axes {
  double x0, x1, log_y0, log_y1;
  double x_px(double x) const { return kLeft_px + (x - x0) / (x1 - x0) * (kRight_px - kLeft_px); }
  double y_px(double y) const {
    return kBottom_px - (std::log10(y) - log_y0) / (log_y1 - log_y0) * (kBottom_px - kTop_px);
  }
};

// One line of the plot; a value of 0 is a gap.
struct Curve {
  const char* name;
  const char* colour;
  const char* dashes;
  std::vector<double> values_mm;
};

/// What a plot shows, of any kind of sweep.
struct Plot {
  std::string varied;
  std::vector<double> x;
  std::vector<std::string> labels;
  std::vector<Curve> curves;

  template <typename AnySweep>
  explicit Plot(const AnySweep& sweep) : varied(sweep.varied) {
    for (const auto& condition : sweep.conditions) x.push_back(condition.plot_x), labels.push_back(condition.label);
  }
  /// \param metres_of  of an outcome
  template <typename Outcomes, typename MetresOf>
  void add(const char* name, const char* colour, const char* dashes, const Outcomes& outcomes, MetresOf metres_of) {
    Curve curve{name, colour, dashes, {}};
    for (const auto& outcome : outcomes) curve.values_mm.push_back(1000 * metres_of(outcome));
    curves.push_back(curve);
  }
};

Axes axes_of(const Plot& plot) {
  double low = 1e9, high = 1e-9;
  for (const Curve& curve : plot.curves)
    for (const double value : curve.values_mm)
      if (value > 0) low = std::min(low, value), high = std::max(high, value);
  return {std::min(0.0, plot.x.front()), plot.x.back(), std::floor(std::log10(low)), std::ceil(std::log10(high))};
}

std::string grid(const Plot& plot, const Axes& axes) {
  std::string svg;
  for (int decade = static_cast<int>(axes.log_y0); decade <= static_cast<int>(axes.log_y1); ++decade) {
    const double y = axes.y_px(std::pow(10, decade));
    svg += fmt::format("<line x1='{}' y1='{:.1f}' x2='{}' y2='{:.1f}' stroke='#dddddd'/>\n", kLeft_px, y, kRight_px, y);
    svg += fmt::format("<text x='{}' y='{:.1f}' text-anchor='end'>{:g}</text>\n", kLeft_px - 8, y + 4,
                       std::pow(10, decade));
  }
  double last_px = -100;
  for (std::size_t i = 0; i < plot.x.size(); ++i) {
    const double x = axes.x_px(plot.x[i]);
    if (x - last_px < 24) continue;
    last_px = x;
    svg += fmt::format("<line x1='{0:.1f}' y1='{1}' x2='{0:.1f}' y2='{2}' stroke='#444444'/>\n", x, kBottom_px,
                       kBottom_px + 5);
    svg += fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle'>{}</text>\n", x, kBottom_px + 19, plot.labels[i]);
  }
  svg += fmt::format("<path d='M{0} {1}V{2}H{3}' fill='none' stroke='#444444'/>\n", kLeft_px, kTop_px, kBottom_px,
                     kRight_px);
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>\n", (kLeft_px + kRight_px) / 2,
                     kBottom_px + 38, plot.varied);
  svg += fmt::format(
      "<text transform='translate(16 {}) rotate(-90)' text-anchor='middle'>position error, rms, mm</text>\n",
      (kTop_px + kBottom_px) / 2);
  return svg;
}

std::string line(const Plot& plot, const Axes& axes, const Curve& curve) {
  std::string path, marks;
  for (std::size_t i = 0; i < curve.values_mm.size(); ++i) {
    if (curve.values_mm[i] <= 0) continue;
    const double x = axes.x_px(plot.x[i]), y = axes.y_px(curve.values_mm[i]);
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x, y);
    if (*curve.dashes == '\0')
      marks += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>\n", x, y, curve.colour);
  }
  return fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='2' stroke-dasharray='{}'/>\n{}", path,
                     curve.colour, curve.dashes, marks);
}

std::string drawn(const Plot& plot) {
  const Axes axes = axes_of(plot);
  std::string svg =
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 620 320' width='620' height='320' font-family='sans-serif' "
      "font-size='12' fill='#222222'>\n<rect width='620' height='320' fill='white'/>\n";
  svg += grid(plot, axes);
  double legend_px = kLeft_px + 8;
  for (const Curve& curve : plot.curves) {
    svg += line(plot, axes, curve);
    svg += fmt::format("<path d='M{} 12h24' stroke='{}' stroke-width='2' stroke-dasharray='{}'/>\n", legend_px,
                       curve.colour, curve.dashes);
    svg += fmt::format("<text x='{}' y='16'>{}</text>\n", legend_px + 30, curve.name);
    legend_px += 60 + 7.0 * static_cast<double>(std::string(curve.name).size());
  }
  return svg + "</svg>\n";
}

}  // namespace

std::string accuracy_plot(const Sweep& sweep) {
  Plot plot(sweep);
  plot.add("Cramer-Rao bound", kGrey, "6 4", sweep.outcomes, [](const Outcome& o) { return o.bound_m; });
  plot.add("full", kBlue, "", sweep.outcomes, [](const Outcome& o) { return o.full.rms_m; });
  plot.add("ellipse", kVermilion, "", sweep.outcomes, [](const Outcome& o) { return o.ellipse.rms_m; });
  return drawn(plot);
}

std::string accuracy_plot(const RoomSweep& sweep) {
  Plot plot(sweep);
  plot.add("joint Cramer-Rao bound", kGrey, "6 4", sweep.outcomes, [](const RoomOutcome& o) { return o.bound_m; });
  plot.add("world, one frame", kBlue, "", sweep.outcomes, [](const RoomOutcome& o) { return o.world.rms_m; });
  plot.add("track, all frames", kVermilion, "", sweep.outcomes, [](const RoomOutcome& o) { return o.track.rms_m; });
  return drawn(plot);
}

}  // namespace ninedot::bench
