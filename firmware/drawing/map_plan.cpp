#include "drawing/map_plan.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

using Place = Transform<frame::World, frame::Landmark>;

// A sheet of A4, landscape, in mm.
constexpr double kPage_mm = 297, kMargin_mm = 14, kLegend_mm = 16;
constexpr const char* kInk = "#1a1a1a";
constexpr const char* kSigma = "#c2410c";

/// 1, 2 or 5 times a power of ten, the largest that is not above `value`.
double round_below(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0})
    if (step * power <= value) return step * power;
  return power;
}

struct View {
  Eigen::Vector2d low_m, high_m;
  double scale_mm_per_m = 1, height_mm = 0;

  Eigen::Vector2d on_page(const Eigen::Vector3d& p_m) const {
    return {kMargin_mm + (p_m.x() - low_m.x()) * scale_mm_per_m,
            height_mm - kLegend_mm - (p_m.y() - low_m.y()) * scale_mm_per_m};
  }
};

View view_of(std::span<const MappedLandmark> landmarks) {
  View view{landmarks.front().T_world_landmark.translation_m.head<2>(), {}};
  view.high_m = view.low_m;
  for (const MappedLandmark& landmark : landmarks) {
    view.low_m = view.low_m.cwiseMin(landmark.T_world_landmark.translation_m.head<2>());
    view.high_m = view.high_m.cwiseMax(landmark.T_world_landmark.translation_m.head<2>());
  }
  // Half a metre around, so that a lone landmark and those on one wall have room.
  view.low_m.array() -= 0.5;
  view.high_m.array() += 0.5;
  const Eigen::Vector2d size_m = view.high_m - view.low_m;
  view.scale_mm_per_m = (kPage_mm - 2 * kMargin_mm) / std::max(size_m.x(), size_m.y());
  view.height_mm = kMargin_mm + kLegend_mm + size_m.y() * view.scale_mm_per_m;
  return view;
}

/// What a landmark takes on the page: less where there are many.
double symbol_mm(std::span<const MappedLandmark> landmarks, const View& view) {
  const Eigen::Vector2d size_mm = (view.high_m - view.low_m) * view.scale_mm_per_m;
  return std::clamp(0.35 * std::sqrt(size_mm.prod() / static_cast<double>(landmarks.size())), 1.0, 5.0);
}

struct Ellipse {
  double long_m, short_m, turn_deg;  ///< half axes; of the long one from X towards Y
};

Ellipse ellipse_of(const MappedLandmark& landmark) {
  const Eigen::Matrix2d in_plane = landmark.covariance.topLeftCorner<2, 2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(in_plane);
  const Eigen::Vector2d direction = axes.eigenvectors().col(1);
  return {std::sqrt(std::max(0.0, axes.eigenvalues()[1])), std::sqrt(std::max(0.0, axes.eigenvalues()[0])),
          std::atan2(direction.y(), direction.x()) * kDegPerRad};
}

std::string draw_landmark(const MappedLandmark& landmark, const View& view, double size_mm, double exaggeration,
                          bool is_origin) {
  const Place& place = landmark.T_world_landmark;
  const Eigen::Vector2d at = view.on_page(place.translation_m);
  // The page's Y goes down.
  const auto turned = [](const Eigen::Vector3d& axis) { return Eigen::Vector2d(axis.x(), -axis.y()).normalized(); };
  const Eigen::Vector2d along = turned(place.rotation.col(0)), out = turned(place.rotation.col(1));
  const Eigen::Vector2d a = at - along * size_mm / 2, b = at + along * size_mm / 2, tip = at + out * size_mm * 0.35;
  const Eigen::Vector2d words = at - out * size_mm * 0.85;
  const double scale = view.scale_mm_per_m * exaggeration;
  const Ellipse ellipse = ellipse_of(landmark);
  std::string text;
  if (ellipse.long_m > 0)
    text += fmt::format(
        "<ellipse rx=\"{:.2f}\" ry=\"{:.2f}\" transform=\"translate({:.2f} {:.2f}) rotate({:.1f})\" fill=\"{}\" "
        "fill-opacity=\"0.15\" stroke=\"{}\" stroke-width=\"0.2\"/>\n",
        ellipse.long_m * scale, ellipse.short_m * scale, at.x(), at.y(), -ellipse.turn_deg, kSigma, kSigma);
  text += fmt::format(
      "<path d=\"M{:.2f} {:.2f} L{:.2f} {:.2f} L{:.2f} {:.2f} Z\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{:.2f}\" "
      "stroke-linejoin=\"round\"/>\n",
      a.x(), a.y(), b.x(), b.y(), tip.x(), tip.y(), is_origin ? kInk : "none", kInk, size_mm * 0.09);
  text += fmt::format(
      "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{:.2f}\" text-anchor=\"middle\" dominant-baseline=\"central\" "
      "fill=\"{}\">{}</text>\n",
      words.x(), words.y(), size_mm * 0.75, kInk, landmark.id);
  return text;
}

std::string draw_legend(const View& view, double exaggeration, bool has_ellipses) {
  const double bar_m = round_below((view.high_m - view.low_m).x() / 4), y_mm = view.height_mm - 6;
  const double end_mm = kMargin_mm + bar_m * view.scale_mm_per_m;
  std::string text = fmt::format(
      "<path d=\"M{0:.2f} {1:.2f} v2 H{2:.2f} v-2\" fill=\"none\" stroke=\"{3}\" "
      "stroke-width=\"0.3\"/>\n<text x=\"{4:.2f}\" y=\"{5:.2f}\" font-size=\"3.5\" "
      "fill=\"{3}\">{6:g} m</text>\n",
      kMargin_mm, y_mm - 2, end_mm, kInk, end_mm + 2, y_mm, bar_m);
  if (has_ellipses)
    text += fmt::format(
        "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"3.5\" text-anchor=\"end\" fill=\"{}\">ellipses: 1-sigma, {:g} "
        "times as large</text>\n",
        kPage_mm - kMargin_mm, y_mm, kSigma, exaggeration);
  return text;
}

}  // namespace

std::string draw_map_plan(std::span<const MappedLandmark> landmarks, std::uint16_t origin) {
  EXPECTS(!landmarks.empty());
  const View view = view_of(landmarks);
  const double size_mm = symbol_mm(landmarks, view);
  double largest_m = 0;
  for (const MappedLandmark& landmark : landmarks) largest_m = std::max(largest_m, ellipse_of(landmark).long_m);
  // The largest ellipse is about as wide as two landmarks.
  const double exaggeration = largest_m > 0 ? round_below(size_mm / (largest_m * view.scale_mm_per_m)) : 1;

  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1:.2f}mm\" viewBox=\"0 0 {0} {1:.2f}\" "
      "font-family=\"Helvetica, Arial, sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      kPage_mm, view.height_mm);
  for (const MappedLandmark& landmark : landmarks)
    text += draw_landmark(landmark, view, size_mm, exaggeration, landmark.id == origin);
  return text + draw_legend(view, exaggeration, largest_m > 0) + "</svg>\n";
}

}  // namespace ninedot
