#include "drawing/overlay_canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ninedot::overlay {
namespace {

constexpr int kFractionBits = 4;  // of OpenCV's drawing coordinates: a sixteenth of a pixel is less than the eye sees
constexpr double kNearest_m = 1e-3;            // 1/z stays finite, and nothing is seen from so near
constexpr double kFarthestOutside_px = 20000;  // OpenCV's fixed-point coordinates overflow some way beyond

constexpr double kShortest_px = 2.5;  // by eye: see draw_chain

// OpenCV's FONT_HERSHEY_DUPLEX at scale 1 has capitals of 21 px (cv::getTextSize).
constexpr int kFont = cv::FONT_HERSHEY_DUPLEX;
constexpr double kCapitalHeight_px = 21;

cv::Point fixed_point(const Eigen::Vector2d& p) {
  constexpr double kOne = 1 << kFractionBits;
  const auto clamp = [](double v) { return std::clamp(v, -kFarthestOutside_px, kFarthestOutside_px); };
  return {static_cast<int>(std::lround(clamp(p.x()) * kOne)), static_cast<int>(std::lround(clamp(p.y()) * kOne))};
}

}  // namespace

std::optional<Eigen::Vector2d> Projector::operator()(const Eigen::Vector3d& p_landmark_m) const {
  const Eigen::Vector3d p_camera_m = T_camera_landmark_ * p_landmark_m;
  if (!(p_camera_m.z() > kNearest_m)) return std::nullopt;
  Eigen::Matrix2d jacobian;
  const Eigen::Vector2d pixel_px = camera_.pixel_from_normalised(p_camera_m.head<2>() / p_camera_m.z(), &jacobian);
  // A polynomial lens model folds back far outside of the picture; there its Jacobian changes sign.
  if (!(jacobian.determinant() > 0) || !(pixel_px.cwiseAbs().maxCoeff() < kFarthestOutside_px)) return std::nullopt;
  return pixel_px;
}

void draw_line(cv::Mat& picture, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Colour& colour,
               double width_px) {
  const int width = std::max(1, static_cast<int>(std::lround(width_px)));
  cv::line(picture, fixed_point(a), fixed_point(b), colour, width, cv::LINE_AA, kFractionBits);
}

void draw_chain(Canvas& canvas, const Projector& project, std::span<const Eigen::Vector3d> chain_m,
                const Colour& colour, double width_px, double dash_px) {
  std::optional<Eigen::Vector2d> previous;
  double length_px = 0;
  for (const Eigen::Vector3d& point_m : chain_m) {
    std::optional<Eigen::Vector2d> next = project(point_m);
    if (next) next = canvas.at(*next);
    const bool last = &point_m == &chain_m.back();
    if (next && previous) {
      // Anti-aliased lines shorter than this come out too faint; a dash must not be shorter either.
      if (!last && (*next - *previous).norm() < kShortest_px) continue;
      const bool gap = dash_px > 0 && std::fmod(length_px, 2 * dash_px) >= dash_px;
      if (!gap) draw_line(canvas.picture, *previous, *next, colour, width_px);
      length_px += (*next - *previous).norm();
    }
    previous = next;
  }
}

void draw_text(cv::Mat& picture, const std::string& text, const Eigen::Vector2d& at, double size, const Colour& colour,
               Align align, bool halo) {
  const double scale = size / kCapitalHeight_px;
  const int width = std::max(1, static_cast<int>(std::lround(size / 11)));
  int base_line = 0;
  const int text_width = cv::getTextSize(text, kFont, scale, width, &base_line).width;
  const double shift = align == Align::kLeft ? 0 : align == Align::kCentre ? 0.5 : 1;
  const cv::Point start(static_cast<int>(std::lround(at.x() - shift * text_width)),
                        static_cast<int>(std::lround(at.y())));
  if (halo) cv::putText(picture, text, start, kFont, scale, kBlack, width + std::max(3, 2 * width + 1), cv::LINE_AA);
  cv::putText(picture, text, start, kFont, scale, colour, width, cv::LINE_AA);
}

}  // namespace ninedot::overlay
