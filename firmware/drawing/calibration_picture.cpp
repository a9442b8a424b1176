#include "drawing/calibration_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr double kPanel = 320, kGap = 24, kMargin = 20, kTop = 58, kBottom = 40;  // CSS px
constexpr const char* kInk = "#1a1a1a";
constexpr const char* kNothing = "#cbd0d6";  // no colour that stands for a number
/// Residuals are averaged over cells of the picture: so many across it.
constexpr int kCells = 16;
/// Most outlines that are drawn by themselves; more make the file large and the picture black.
constexpr std::size_t kMostDots = 4000;

/// White over yellow and red to black: dark is bad. \param share  0..1
std::string heat(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  const auto part = [](double x) { return static_cast<int>(std::lround(255 * std::clamp(x, 0.0, 1.0))); };
  return fmt::format("#{:02x}{:02x}{:02x}", part(2.2 - 1.9 * s), part(1.25 - 1.25 * s), part(1 - 3 * s));
}

/// 1, 2 or 5 times a power of ten, the smallest that is not below `value`.
double round_above(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(std::max(value, 1e-9))));
  for (const double step : {1.0, 2.0, 5.0})
    if (step * power >= value * (1 - 1e-9)) return step * power;
  return 10 * power;
}

struct Panel {
  double left, scale, height;
  double x(double px) const { return left + (px + 0.5) * scale; }
  double y(double px) const { return kTop + (px + 0.5) * scale; }
};

std::string frame_of(const Panel& panel, const char* heading, const std::string& below) {
  return fmt::format(
      "<rect x=\"{:.1f}\" y=\"{}\" width=\"{}\" height=\"{:.1f}\" fill=\"none\" stroke=\"{}\"/>\n"
      "<text x=\"{:.1f}\" y=\"{}\" font-size=\"13\" font-weight=\"bold\">{}</text>\n"
      "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"12\">{}</text>\n",
      panel.left, kTop, kPanel, panel.height, kInk, panel.left, kTop - 8, heading, panel.left, kTop + panel.height + 18,
      below);
}

std::string draw_coverage(const CalibrationDrawing& drawing, const Panel& panel) {
  std::string text;
  std::size_t count = 0;
  for (const auto& view : drawing.disc_centres) count += view.size();
  const std::size_t every = 1 + count / kMostDots;
  for (const auto& view : drawing.disc_centres)
    for (std::size_t i = 0; i < view.size(); i += every)
      text += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.2\" fill=\"#1d4ed8\" fill-opacity=\"0.4\"/>\n",
                          panel.x(view[i].x()), panel.y(view[i].y()));
  return text + frame_of(panel, "Where the sheet was seen", fmt::format("{} views", drawing.disc_centres.size()));
}

std::string draw_residuals(const CalibrationDrawing& drawing, const Panel& panel) {
  const double cell_px = static_cast<double>(drawing.width_px) / kCells;
  const int rows = static_cast<int>(std::ceil(drawing.height_px / cell_px));
  std::vector<double> squares(static_cast<std::size_t>(kCells * rows)), counts(squares.size());
  for (const DrawnResidual& residual : drawing.residuals) {
    const int column = std::clamp(static_cast<int>(residual.at_px.x() / cell_px), 0, kCells - 1);
    const int row = std::clamp(static_cast<int>(residual.at_px.y() / cell_px), 0, rows - 1);
    const auto cell = static_cast<std::size_t>(row) * kCells + static_cast<std::size_t>(column);
    squares[cell] += residual.off_px * residual.off_px, ++counts[cell];
  }
  double largest_px = 1e-3;
  for (std::size_t cell = 0; cell < squares.size(); ++cell)
    if (counts[cell] > 0) largest_px = std::max(largest_px, std::sqrt(squares[cell] / counts[cell]));
  const double scale_px = round_above(largest_px);
  std::string text = fmt::format("<rect x=\"{:.1f}\" y=\"{}\" width=\"{}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                                 panel.left, kTop, kPanel, panel.height, kNothing);
  for (std::size_t cell = 0; cell < squares.size(); ++cell) {
    if (counts[cell] == 0) continue;
    const auto column = static_cast<int>(cell) % kCells, row = static_cast<int>(cell) / kCells;
    const double side = cell_px * panel.scale, top = kTop + row * side;
    text += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                        panel.left + column * side, top, side, std::min(side, kTop + panel.height - top),
                        heat(std::sqrt(squares[cell] / counts[cell]) / scale_px));
  }
  return text + frame_of(panel, "What outlines are off",
                         fmt::format("rms, white 0 to black {:g} px; grey: none there", scale_px));
}

std::string draw_directions(const CalibrationDrawing& drawing, const Panel& panel) {
  double largest_px = 1e-4;
  for (const double sigma_px : drawing.direction_sigma_px)
    if (std::isfinite(sigma_px)) largest_px = std::max(largest_px, sigma_px);
  const double scale_px = round_above(largest_px);
  const double width = kPanel / drawing.columns, height = panel.height / drawing.rows;
  std::string cells, numbers;  // above all cells
  for (std::size_t i = 0; i < drawing.direction_sigma_px.size(); ++i) {
    const auto column = static_cast<int>(i) % drawing.columns, row = static_cast<int>(i) / drawing.columns;
    const double sigma_px = drawing.direction_sigma_px[i];
    cells += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n",
                         panel.left + column * width, kTop + row * height, width + 0.3, height + 0.3,
                         std::isfinite(sigma_px) ? heat(sigma_px / scale_px) : kInk);
    if (column % 6 == 3 && row % 6 == 3 && std::isfinite(sigma_px))
      numbers +=
          fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"11\" text-anchor=\"middle\"{}>{:.2g}</text>\n",
                      panel.left + (column + 0.5) * width, kTop + (row + 0.5) * height + 4,
                      sigma_px > 0.6 * scale_px ? " fill=\"#ffffff\"" : "", sigma_px);
  }
  return cells + numbers +
         frame_of(panel, "Expected error of directions", fmt::format("1-sigma, white 0 to black {:g} px", scale_px));
}

}  // namespace

std::string draw_calibration(const CalibrationDrawing& drawing) {
  EXPECTS(drawing.width_px > 0 && drawing.height_px > 0 && drawing.columns > 0 && drawing.rows > 0);
  const double scale = kPanel / drawing.width_px, height = scale * drawing.height_px;
  const double width = 3 * kPanel + 2 * kGap + 2 * kMargin;
  const auto panel = [&](int i) { return Panel{kMargin + i * (kPanel + kGap), scale, height}; };
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1:.0f}\" viewBox=\"0 0 {0} {1:.0f}\" "
      "font-family=\"Helvetica, Arial, sans-serif\" fill=\"{2}\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"#ffffff\"/>\n<text x=\"{3}\" y=\"24\" font-size=\"15\">{4}</text>\n",
      width, kTop + height + kBottom, kInk, kMargin, drawing.title);
  text += draw_coverage(drawing, panel(0)) + draw_residuals(drawing, panel(1)) + draw_directions(drawing, panel(2));
  return text + "</svg>\n";
}

}  // namespace ninedot
