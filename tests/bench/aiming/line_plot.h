#pragma once
/// A small plot of lines, as SVG.
#include <string>
#include <utility>
#include <vector>

namespace ninedot::bench {

struct PlotLine {
  std::string name;
  std::string colour;                             ///< "#0072B2"
  std::vector<std::pair<double, double>> points;  ///< (x, y) in the axes' units
};

struct LinePlot {
  std::string x_label, y_label;
  double y_end = 1;  ///< in its units: what is larger is cut there
  std::vector<PlotLine> lines;
  std::vector<std::pair<double, double>> grey;  ///< from..to in x: shaded
};

/// Axes begin at 0.
std::string drawn(const LinePlot& plot);

}  // namespace ninedot::bench
