#include "drawing/overlay_panel.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string>

#include "base/units.h"
#include "drawing/overlay_canvas.h"

namespace ninedot::overlay {
namespace {

constexpr double kLeft_units = 30, kValue_units = 258, kSigma_units = 410;  // label from; value and sigma up to
constexpr double kRow_units = 31, kTextSize_units = 14;                     // chosen by eye

/// Writes rows from the top to the bottom of a panel.
class Rows {
 public:
  Rows(cv::Mat& panel, double unit_px, double top_units) : panel_(panel), unit_px_(unit_px), y_units_(top_units) {}

  void row(const std::string& label, const std::string& value, const std::string& right = {},
           const Colour& colour = kText) {
    text(label, kLeft_units, Align::kLeft, kFaint);
    text(value, kValue_units, Align::kRight, colour);
    text(right, kSigma_units, Align::kRight, kFaint);
    y_units_ += kRow_units;
  }
  void line(const std::string& words, const Colour& colour) {
    text(words, kLeft_units, Align::kLeft, colour);
    y_units_ += kRow_units;
  }
  void gap() { y_units_ += 0.4 * kRow_units; }

 private:
  void text(const std::string& words, double x_units, Align align, const Colour& colour) {
    draw_text(panel_, words, Eigen::Vector2d(x_units, y_units_) * unit_px_, kTextSize_units * unit_px_, colour, align);
  }
  cv::Mat& panel_;
  double unit_px_;
  double y_units_;
};

/// As many decimals as leave two digits of the uncertainty: more would be noise.
int decimals_for(double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma)) return 2;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 3);
}

double sigma_of(const Report& report, std::size_t i) { return std::sqrt(report.covariance[7 * i]); }

void draw_verdict(cv::Mat& panel, const Report& report, double unit_px) {
  const bool doubtful = (report.valid && !report.calibrated) || report.ambiguous;
  const Colour& colour = doubtful ? kDoubtful : report.valid ? kGood : kBad;
  const char* const verdict = report.calibrated ? "found" : "uncalibrated";
  const std::string words = report.valid       ? fmt::format("landmark {} {}", report.landmark_id, verdict)
                            : report.ambiguous ? "ambiguous"
                            : report.found     ? "no pose"
                                               : "no landmark";
  const double height_units = 58;
  panel.rowRange(0, static_cast<int>(height_units * unit_px)).setTo(colour);
  draw_text(panel, words, Eigen::Vector2d(kLeft_units, 39) * unit_px, 19 * unit_px, {255, 255, 255});
}

void draw_pose_rows(Rows& rows, const Report& report) {
  const char* const names[] = {"x", "y", "z"};
  rows.row("camera", "mm", "1-sigma", kFaint);
  double largest_sigma_mm = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma_mm = sigma_of(report, i) * 1e3;
    largest_sigma_mm = std::fmax(largest_sigma_mm, sigma_mm);
    const int decimals = decimals_for(sigma_mm);
    rows.row(names[i], fmt::format("{:.{}f}", report.camera_in_landmark.position_m[i] * 1e3, decimals),
             fmt::format("{:.{}f}", sigma_mm, decimals));
  }
  const double sigma_rotation_deg =
      kDegPerRad * std::hypot(sigma_of(report, 3), sigma_of(report, 4), sigma_of(report, 5));
  rows.row("rotation", "", fmt::format("{:.{}f} deg", sigma_rotation_deg, decimals_for(sigma_rotation_deg)));
  rows.gap();
  rows.row("distance", fmt::format("{:.{}f}", report.distance_m * 1e3, decimals_for(largest_sigma_mm)), "mm");
  rows.row("tilt", fmt::format("{:.2f}", report.tilt_phi_rad * kDegPerRad), "deg");
  rows.row("dots used", fmt::format("{} / 9", report.dots_used),
           report.occlusion_level == 0 ? "no occlusion" : fmt::format("occl. level {}", report.occlusion_level),
           report.dots_used == 9 ? kText : kHidden);
  rows.row("residual rms", fmt::format("{:.3f}", report.rms_px), "px");
  rows.row("ambiguity", fmt::format("{:.3f}", report.ambiguity), "0..1", report.ambiguous ? kHidden : kText);
}

void draw_process_row(Rows& rows, const Report& report) {
  const double time_ms = std::chrono::duration<double, std::milli>(report.process_time).count();
  rows.row("process time", fmt::format("{:.2f}", time_ms), "ms");
  rows.row("frame", fmt::format("{}", report.frame_number), report.solver == Solver::kFull ? "full" : "ellipse");
}

void draw_key(cv::Mat& panel, KeyOf what, double unit_px) {
  const auto entry = [&](double x_units, double y_units, const Colour& colour, const char* words, bool dashed,
                         bool cross) {
    const Eigen::Vector2d at = Eigen::Vector2d(x_units, y_units) * unit_px;
    const Eigen::Vector2d right(unit_px, 0), down(0, unit_px);
    if (cross) {
      draw_line(panel, at + 8 * right, at + 20 * right, colour, unit_px);
      draw_line(panel, at + 14 * right - 6 * down, at + 14 * right + 6 * down, colour, unit_px);
    } else {
      draw_line(panel, at, at + (dashed ? 11 : 28) * right, colour, 2 * unit_px);
      if (dashed) draw_line(panel, at + 17 * right, at + 28 * right, colour, 2 * unit_px);
    }
    draw_text(panel, words, at + 38 * right + 5 * down, 10.5 * unit_px, kFaint);
  };
  if (what == KeyOf::kFailedSearch) {
    entry(30, 884, kRing, "dark spot", false, false);
    entry(30, 910, kOutline, "what comes nearest to a landmark: a dot", false, false);
    return entry(30, 936, kHidden, "and where it lacks one", true, false);
  }
  entry(30, 884, kOutline, "disc from the pose", false, false);
  entry(30, 910, kHidden, "hidden disc", true, false);
  entry(245, 884, kCentroid, "centroid seen", false, true);
  entry(245, 910, kRing, "ring P1..P8", false, false);
  const double row_units = 936;
  entry(30, row_units, kAxisX, "X0", false, false);
  entry(140, row_units, kAxisY, "Y0, to you", false, false);
  entry(310, row_units, kAxisZ, "Z0, up", false, false);
}

}  // namespace

void draw_panel(cv::Mat& panel, const Report& report, KeyOf key, double unit_px) {
  panel.setTo(kBacking);
  draw_verdict(panel, report, unit_px);
  Rows rows(panel, unit_px, 58 + 30);
  if (report.valid) {
    draw_pose_rows(rows, report);
  } else {
    rows.line(std::string(reason_label(report.reason)), kText);
    rows.gap();
  }
  draw_process_row(rows, report);
  draw_key(panel, key, unit_px);
}

}  // namespace ninedot::overlay
