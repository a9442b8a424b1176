// A frame enlarged, the landmark drawn into it as the pose predicts it, and a panel of numbers on its right, where it
// hides nothing. A small landmark is drawn in a magnified cut-out; in the frame it only gets brackets, or the lines
// would bury it. Everything goes through Canvas, so the frame and the cut-out are drawn by the same code.
#include "drawing/overlay.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/contract.h"
#include "drawing/overlay_canvas.h"
#include "drawing/overlay_panel.h"

namespace ninedot {
namespace {

using namespace overlay;
using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;

constexpr double kSmallSpan_px = 100;       // of the frame: below, the cut-out shows more than the frame does
constexpr double kInsetMargin = 1.45;       // side of the cut-out over the span of the landmark: room for the labels
constexpr double kAxisLength_radii = 0.75;  // of the ring: the tips end before the ring dots and hide none
// Every 2.5 deg, first = last: a chord is off by 2.4e-4 of the radius, 0.24 px at a radius of 1000.
constexpr std::size_t kCirclePoints = 145;

// Of a guess that is none dots may be anywhere: beyond this nothing of them would be in the picture.
constexpr double kFarthest_px = 1e5;

using Circle = std::array<Vector3, kCirclePoints>;

Circle circle_m(const Vector2& centre_m, double radius_m) {
  Circle circle;
  for (std::size_t i = 0; i < kCirclePoints; ++i) {
    const double a_rad = 2 * std::numbers::pi * static_cast<double>(i) / (kCirclePoints - 1);
    circle[i] = {centre_m.x() + radius_m * std::cos(a_rad), 0, centre_m.y() + radius_m * std::sin(a_rad)};
  }
  return circle;
}

Transform<frame::Landmark, frame::Camera> pose_of(const ReportPose& pose) {
  const auto& q = pose.quaternion_wxyz;
  const auto& p = pose.position_m;
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix(), Vector3(p[0], p[1], p[2])};
}

/// What is drawn: everything a canvas needs to know about the landmark.
struct Scene {
  std::optional<Projector> project;  // with a valid pose
  const LandmarkObservation* seen;
  const LandmarkGeometry& geometry;

  bool dot_seen(std::size_t dot) const { return seen == nullptr || seen->dots[dot].seen; }
};

struct Box {
  Vector2 low_px{1e9, 1e9}, high_px{-1e9, -1e9};
  void add(const Vector2& p) { low_px = low_px.cwiseMin(p), high_px = high_px.cwiseMax(p); }
  bool empty() const { return !(low_px.x() <= high_px.x()); }
  double span_px() const { return (high_px - low_px).maxCoeff(); }
  Vector2 middle_px() const { return (low_px + high_px) / 2; }
};

Box landmark_box(const Scene& scene) {
  Box box;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (scene.project) {
      for (const Vector3& p : circle_m(scene.geometry.centre_m(dot), scene.geometry.radius_m(dot)))
        if (const auto pixel = (*scene.project)(p)) box.add(*pixel);
    } else if (scene.seen != nullptr && scene.seen->dots[dot].seen) {
      const DotObservation& seen = scene.seen->dots[dot];
      box.add(seen.centroid_px - Vector2::Constant(seen.semi_major_px));
      box.add(seen.centroid_px + Vector2::Constant(seen.semi_major_px));
    }
  }
  return box;
}

void draw_discs(Canvas& canvas, const Scene& scene) {
  const Projector& project = *scene.project;
  draw_chain(canvas, project, circle_m(Vector2::Zero(), scene.geometry.ring_radius_m), kRing, canvas.line_px);
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Circle outline = circle_m(scene.geometry.centre_m(dot), scene.geometry.radius_m(dot));
    const bool seen = scene.dot_seen(dot);
    const auto right = project(outline[0]), left = project(outline[kCirclePoints / 2]);
    const bool small = right && left && (*right - *left).norm() * canvas.scale < 18 * canvas.line_px;
    draw_chain(canvas, project, outline, seen ? kOutline : kHidden, (small && seen ? 1 : 2) * canvas.line_px,
               seen ? 0 : 8 * canvas.line_px);
  }
}

void draw_axes(Canvas& canvas, const Scene& scene) {
  const double length_m = kAxisLength_radii * scene.geometry.ring_radius_m;
  const std::array<const char*, 3> names{"X0", "Y0", "Z0"};
  const std::array<Colour, 3> colours{kAxisX, kAxisY, kAxisZ};
  const auto origin = (*scene.project)(Vector3::Zero());
  for (const int axis : {0, 2, 1}) {  // Y0 last: it comes out of the sheet, over the others
    const auto tip = (*scene.project)(length_m * Vector3::Unit(axis));
    if (!origin || !tip) continue;
    const auto i = static_cast<std::size_t>(axis);
    const Vector2 a = canvas.at(*origin), b = canvas.at(*tip);
    draw_line(canvas.picture, a, b, kBlack, 5 * canvas.line_px);
    draw_line(canvas.picture, a, b, colours[i], 3 * canvas.line_px);
    // The letters of X0 and Z0 stand beside the tips, since a ring dot follows in the axis's direction.
    const double size = 12 * canvas.line_px;
    const Vector2 along = (b - a).norm() > 1 ? Vector2((b - a).normalized()) : Vector2(0, 0);
    const Vector2 aside = axis == 1 ? along : Vector2(Vector2(-along.y(), along.x()) - 0.3 * along);
    draw_text(canvas.picture, names[i], b + aside * size * 1.4 + Vector2(0, size / 2), size, colours[i], Align::kCentre,
              true);
  }
}

/// P1..P8 outside of the ring, P9 beside the centre dot where no axis runs.
void draw_labels(Canvas& canvas, const Scene& scene) {
  const LandmarkGeometry& geometry = scene.geometry;
  const double size = 12 * canvas.line_px;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Vector2 ring_m = dot == kCentreDot ? geometry.centre_m(7) : geometry.centre_m(dot);
    const double outwards = dot == kCentreDot
                                ? 0.5 * (geometry.centre_radius_m + geometry.ring_radius_m - geometry.dot_radius_m)
                                : geometry.ring_radius_m + geometry.dot_radius_m;
    const Vector2 place_m = ring_m.normalized() * outwards;
    const auto place = (*scene.project)({place_m.x(), 0, place_m.y()});
    const auto middle = (*scene.project)(Vector3::Zero());
    if (!place || !middle) continue;
    Vector2 at = canvas.at(*place);
    if (dot != kCentreDot) at += (at - canvas.at(*middle)).normalized() * 1.5 * size;
    draw_text(canvas.picture, fmt::format("P{}", dot + 1), at + Vector2(0, size / 2), size,
              scene.dot_seen(dot) ? kText : kHidden, Align::kCentre, true);
  }
}

void draw_centroids(Canvas& canvas, const Scene& scene) {
  if (scene.seen == nullptr || scene.seen->from_pose) return;
  for (const DotObservation& dot : scene.seen->dots) {
    if (!dot.seen) continue;
    const Vector2 at = canvas.at(dot.centroid_px);
    const double arm = std::clamp(0.45 * dot.semi_minor_px * canvas.scale, 3 * canvas.line_px, 9 * canvas.line_px);
    for (const Vector2& way : {Vector2(arm, 0), Vector2(0, arm)})
      draw_line(canvas.picture, at - way, at + way, kCentroid, canvas.line_px);
  }
}

/// An outline as it was seen. \param dash_px  of the picture; 0 = unbroken
void draw_ellipse(Canvas& canvas, const DotObservation& dot, const Colour& colour, double width_px,
                  double dash_px = 0) {
  if (!(dot.centroid_px.lpNorm<Eigen::Infinity>() + dot.semi_major_px < kFarthest_px)) return;  // or not a number
  const Vector2 along(std::cos(dot.angle_rad), std::sin(dot.angle_rad)), across(-along.y(), along.x());
  double length_px = 0;
  Vector2 before = canvas.at(dot.centroid_px + dot.semi_major_px * along);
  for (std::size_t i = 1; i < kCirclePoints; ++i) {
    const double a_rad = 2 * std::numbers::pi * static_cast<double>(i) / (kCirclePoints - 1);
    const Vector2 point = canvas.at(dot.centroid_px + dot.semi_major_px * std::cos(a_rad) * along +
                                    dot.semi_minor_px * std::sin(a_rad) * across);
    if (dash_px == 0 || std::fmod(length_px, 2 * dash_px) < dash_px)
      draw_line(canvas.picture, before, point, colour, width_px);
    length_px += (point - before).norm();
    before = point;
  }
}

/// Without a pose: the outlines as they were seen.
void draw_seen_ellipses(Canvas& canvas, const Scene& scene) {
  if (scene.seen == nullptr) return;
  for (const DotObservation& dot : scene.seen->dots)
    if (dot.seen) draw_ellipse(canvas, dot, kOutline, 2 * canvas.line_px);
}

/// What there was to see where nothing was found.
void draw_failed_search(Canvas& canvas, const FailedSearch& failed) {
  for (const Blob& spot : failed.spots) {
    DotObservation outline;
    outline.centroid_px = {spot.x_px, spot.y_px};
    set_outline(spot.moments_px2(), outline);
    draw_ellipse(canvas, outline, kRing, canvas.line_px);
  }
  if (failed.refusal == Refusal::kNone) return;
  for (const DotObservation& dot : failed.dots)
    draw_ellipse(canvas, dot, dot.seen ? kOutline : kHidden, 2 * canvas.line_px, dot.seen ? 0 : 5 * canvas.line_px);
}

void draw_landmark(Canvas& canvas, const Scene& scene) {
  if (!scene.project) {
    draw_seen_ellipses(canvas, scene);
    draw_centroids(canvas, scene);
    return;
  }
  draw_discs(canvas, scene);
  draw_axes(canvas, scene);
  draw_centroids(canvas, scene);
  draw_labels(canvas, scene);
}

/// Corner brackets around a landmark too small to be drawn over.
void draw_brackets(Canvas& canvas, const Box& box) {
  const double half = canvas.scale * box.span_px() * kInsetMargin / 2;
  const double arm = std::max(half / 3, 8 * canvas.line_px);
  const Vector2 middle = canvas.at(box.middle_px());
  for (const double width_px : {5 * canvas.line_px, 2 * canvas.line_px})
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0}) {
        const Vector2 corner = middle + half * Vector2(x, y);
        const Colour& colour = width_px > 3 * canvas.line_px ? kBlack : kOutline;
        draw_line(canvas.picture, corner, corner - Vector2(arm * x, 0), colour, width_px);
        draw_line(canvas.picture, corner, corner - Vector2(0, arm * y), colour, width_px);
      }
}

void draw_inset(cv::Mat& panel, const cv::Mat& frame, const Scene& scene, const Box& box, double unit_px) {
  const int side = static_cast<int>(kInsetSide_units * unit_px);
  const cv::Rect place(static_cast<int>(kInsetLeft_units * unit_px), static_cast<int>(kInsetTop_units * unit_px), side,
                       side);
  Canvas inset;
  inset.picture = panel(place);
  const double shown_px = std::max(box.span_px() * kInsetMargin, 8.0);
  inset.scale = side / shown_px;
  inset.origin_px = box.middle_px() - Vector2::Constant(shown_px / 2) + Vector2(0.5, 0.5);
  inset.line_px = unit_px;
  const Vector2 zero = inset.at({0, 0});
  const cv::Matx23d picture_from_frame(inset.scale, 0, zero.x(), 0, inset.scale, zero.y());
  cv::Mat grey;
  // Nearest: what the camera's pixels held, not what an interpolation makes of them.
  cv::warpAffine(frame, grey, picture_from_frame, inset.picture.size(), cv::INTER_NEAREST, cv::BORDER_CONSTANT, {40});
  cv::cvtColor(grey, inset.picture, cv::COLOR_GRAY2RGB);
  draw_landmark(inset, scene);
  cv::rectangle(panel, place, kOutline, std::max(1, static_cast<int>(2 * unit_px)));
  draw_text(panel, fmt::format("{:.1f} x", inset.scale), Vector2(place.x + 8 * unit_px, place.y + side - 9 * unit_px),
            11 * unit_px, kText, Align::kLeft, true);
}

/// Across the middle of the frame, in words nobody can overlook.
void draw_nothing_found(Canvas& canvas, const Report& report, const FailedSearch* failed) {
  const cv::Size size = canvas.picture.size();
  const double unit_px = std::min(size.width / 640.0, size.height / 240.0);
  const int height = static_cast<int>((failed != nullptr ? 58 : 46) * unit_px);
  cv::Mat band = canvas.picture.rowRange(std::max(0, size.height - height), size.height);
  band *= 0.25;
  draw_text(band, report.found ? "no pose" : "no landmark", Vector2(size.width / 2.0, 21 * unit_px), 13 * unit_px,
            {255, 110, 110}, Align::kCentre, true);
  draw_text(band, std::string(reason_label(report.reason)), Vector2(size.width / 2.0, 38 * unit_px), 8 * unit_px, kText,
            Align::kCentre, true);
  if (failed == nullptr) return;
  const std::string what = failed->refusal != Refusal::kNone
                               ? fmt::format("outlined: {}", refusal_sentence(failed->refusal))
                               : "dark spots are outlined: no nine of them lie like its dots";
  draw_text(band, what, Vector2(size.width / 2.0, 51 * unit_px), 6 * unit_px, kText, Align::kCentre, true);
}

}  // namespace

int overlay_scale(int height_px) noexcept { return std::clamp((900 + height_px - 1) / std::max(height_px, 1), 1, 8); }

void draw_overlay(const ImageView& luma, const Report& report, const LandmarkObservation* seen,
                  const FailedSearch* failed, const CameraModel& camera, const LandmarkGeometry& geometry, int scale,
                  RgbPicture& picture) {
  EXPECTS(!luma.empty() && scale >= 0);
  // Pictures of this size gain nothing from OpenCV's worker threads, which would outlive the call and take the cores
  // of the frame loop; the thread sanitizer cannot look into them either.
  cv::setNumThreads(1);
  if (scale == 0) scale = overlay_scale(luma.height_px);
  const int width = luma.width_px * scale, height = luma.height_px * scale;
  const double unit_px = std::clamp(height / kPanelHeight_units, 0.75, 4.0);
  const int panel_width = static_cast<int>(kPanelWidth_units * unit_px);
  picture.width_px = width + panel_width;
  picture.height_px = std::max(height, static_cast<int>(std::ceil(kPanelHeight_units * unit_px)));
  picture.pixels.resize(3 * static_cast<std::size_t>(picture.width_px) * static_cast<std::size_t>(picture.height_px));
  cv::Mat whole(picture.height_px, picture.width_px, CV_8UC3, picture.pixels.data());
  whole.setTo(kBacking);

  // OpenCV has no view of constant pixels; this one is only read.
  const cv::Mat frame(luma.height_px, luma.width_px, CV_8UC1, const_cast<std::uint8_t*>(luma.pixels),
                      static_cast<std::size_t>(luma.stride_bytes));
  Canvas canvas;
  canvas.picture = whole(cv::Rect(0, 0, width, height));
  canvas.scale = scale;
  canvas.line_px = unit_px;
  cv::Mat grey;
  cv::resize(frame, grey, canvas.picture.size(), 0, 0, cv::INTER_CUBIC);
  cv::cvtColor(grey, canvas.picture, cv::COLOR_GRAY2RGB);

  Scene scene{std::nullopt, report.found ? seen : nullptr, geometry};
  if (report.valid) scene.project.emplace(camera, pose_of(report.camera_in_landmark));
  const Box box = landmark_box(scene);
  cv::Mat panel = whole.colRange(width, picture.width_px);
  draw_panel(panel, report, failed != nullptr ? KeyOf::kFailedSearch : KeyOf::kLandmark, unit_px);
  if (failed != nullptr) draw_failed_search(canvas, *failed);
  if (!report.valid) draw_nothing_found(canvas, report, failed);
  if (box.empty()) return;
  if (box.span_px() >= kSmallSpan_px) {
    draw_landmark(canvas, scene);
  } else {
    draw_brackets(canvas, box);
    draw_inset(panel, frame, scene, box, unit_px);
  }
}

}  // namespace ninedot
