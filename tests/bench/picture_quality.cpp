// Everything is read at places that the true pose names: paper and ink from spots well inside each, noise from second
// differences along rows (a light gradient cancels; sigma of x[-1] - 2 x[0] + x[1] is sqrt(6) sigma), and the blur from
// the pixels within a few px of P9's outline: grey = ink + (paper - ink) Phi((d - shift) / blur), d the signed distance
// to the outline. Paper and ink are fitted per sector of 45 degrees, so that a shadow across the sheet does not look
// like blur; the common shift is what a tone curve does to an outline.
#include "tests/bench/picture_quality.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace ninedot::bench {
namespace {

using Pose = Transform<frame::Landmark, frame::Camera>;

constexpr double kUnknownNoise_lsb = 2.0;
constexpr double kUnknownBlur_px = 0.6;
constexpr double kMinContrast_lsb = 5.0;
constexpr std::size_t kSectors = 8;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A sheet as one picture shows it: everything the measurements below ask of it.
struct Sight {
  const ImageView& luma;
  const CameraModel& camera;
  const LandmarkGeometry& landmark;
  const Pose& pose;

  double px_per_m() const {
    return camera.fx_px / std::max(1e-3, (pose.rotation.transpose() * -pose.translation_m).z());
  }
  /// Distance from P9's middle in the sheet's plane [m]; infinite where the ray misses the plane.
  double radius_m(int x, int y) const {
    const auto point = sheet_of_pixel(camera, pose, {x, y});
    return point ? point->norm() : std::numeric_limits<double>::infinity();
  }
};

std::vector<double> grey_on_circles(const Sight& sight, std::initializer_list<double> radii_m) {
  std::vector<double> values;
  for (const double radius_m : radii_m) {
    for (int i = 0; i < 24; ++i) {
      const double a_rad = i * std::numbers::pi / 12;
      const auto pixel =
          pixel_of_sheet(sight.camera, sight.pose, radius_m * Eigen::Vector2d(std::sin(a_rad), std::cos(a_rad)));
      if (!pixel) continue;
      const int x = static_cast<int>(std::lround(pixel->x())), y = static_cast<int>(std::lround(pixel->y()));
      if (sight.luma.contains(x, y)) values.push_back(sight.luma.at(x, y));
    }
  }
  return values;
}

/// The rectangle around P9 out to `reach_m` in the sheet, clipped to the picture: {x0, y0, x1, y1}, ends included.
std::array<int, 4> surroundings_px(const Sight& sight, double reach_m) {
  std::array<int, 4> box{sight.luma.width_px, sight.luma.height_px, -1, -1};
  for (int i = 0; i < 24; ++i) {
    const double a_rad = i * std::numbers::pi / 12;
    const auto pixel =
        pixel_of_sheet(sight.camera, sight.pose, reach_m * Eigen::Vector2d(std::sin(a_rad), std::cos(a_rad)));
    if (!pixel) continue;
    box[0] = std::min(box[0], static_cast<int>(std::floor(pixel->x())) - 3);
    box[1] = std::min(box[1], static_cast<int>(std::floor(pixel->y())) - 3);
    box[2] = std::max(box[2], static_cast<int>(std::ceil(pixel->x())) + 3);
    box[3] = std::max(box[3], static_cast<int>(std::ceil(pixel->y())) + 3);
  }
  return {std::max(box[0], 0), std::max(box[1], 0), std::min(box[2], sight.luma.width_px - 1),
          std::min(box[3], sight.luma.height_px - 1)};
}

double measure_noise(const Sight& sight) {
  const double margin_m = 2.5 / sight.px_per_m();
  const double inner_m = sight.landmark.centre_radius_m + margin_m;
  const double outer_m = sight.landmark.ring_radius_m - sight.landmark.dot_radius_m - margin_m;
  const auto [x0, y0, x1, y1] = surroundings_px(sight, std::max(outer_m, inner_m));
  const auto blank = [&](int x, int y) {
    const double radius_m = sight.radius_m(x, y);
    return radius_m > inner_m && radius_m < outer_m;
  };
  std::vector<double> differences;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0 + 1; x < x1; ++x) {
      if (!blank(x - 1, y) || !blank(x, y) || !blank(x + 1, y)) continue;
      differences.push_back(sight.luma.at(x - 1, y) - 2.0 * sight.luma.at(x, y) + sight.luma.at(x + 1, y));
    }
  }
  if (differences.size() < 40) return kUnknownNoise_lsb;
  std::vector<double> sizes;
  for (const double difference : differences) sizes.push_back(std::abs(difference));
  const double limit = 4 * std::max(1.0, 1.4826 * median(sizes));  // a shadow's edge is no noise
  double sum = 0;
  int count = 0;
  for (const double size : sizes) {
    if (size <= limit) sum += size * size, ++count;
  }
  return std::max(0.5, std::sqrt(sum / count / 6));
}

struct OutlinePixel {
  double distance_px = 0;  ///< from P9's outline, positive outside
  double grey = 0;
  std::size_t sector = 0;
};

std::vector<OutlinePixel> outline_pixels(const Sight& sight, double reach_px) {
  std::vector<OutlinePixel> pixels;
  const double radius_m = sight.landmark.centre_radius_m;
  const auto [x0, y0, x1, y1] = surroundings_px(sight, radius_m + reach_px / sight.px_per_m());
  for (int y = y0 + 1; y < y1; ++y) {
    for (int x = x0 + 1; x < x1; ++x) {
      const Eigen::Vector2d slope{(sight.radius_m(x + 1, y) - sight.radius_m(x - 1, y)) / 2,
                                  (sight.radius_m(x, y + 1) - sight.radius_m(x, y - 1)) / 2};
      const double distance_px = (sight.radius_m(x, y) - radius_m) / slope.norm();
      if (!(std::abs(distance_px) <= reach_px)) continue;
      const double a_rad = std::atan2(slope.y(), slope.x()) + std::numbers::pi;
      const auto sector = static_cast<std::size_t>(a_rad / (2 * std::numbers::pi) * kSectors) % kSectors;
      pixels.push_back({distance_px, static_cast<double>(sight.luma.at(x, y)), sector});
    }
  }
  return pixels;
}

/// Sum of squared residuals when each sector has its own best paper and ink.
double misfit(const std::vector<OutlinePixel>& pixels, double blur_px, double shift_px) {
  std::array<Eigen::Matrix2d, kSectors> normal;
  std::array<Eigen::Vector2d, kSectors> right;
  normal.fill(1e-9 * Eigen::Matrix2d::Identity());
  right.fill(Eigen::Vector2d::Zero());
  double total = 0;
  for (const OutlinePixel& pixel : pixels) {
    const double paper = 0.5 * (1 + std::erf((pixel.distance_px - shift_px) / (blur_px * std::numbers::sqrt2)));
    const Eigen::Vector2d row{paper, 1 - paper};
    normal[pixel.sector] += row * row.transpose();
    right[pixel.sector] += row * pixel.grey;
    total += pixel.grey * pixel.grey;
  }
  for (std::size_t i = 0; i < kSectors; ++i) total -= right[i].dot(normal[i].ldlt().solve(right[i]));
  return total;
}

double measure_blur(const Sight& sight) {
  const double radius_px = sight.landmark.centre_radius_m * sight.px_per_m();
  const auto pixels = outline_pixels(sight, std::min(4.0, 0.6 * radius_px));
  if (radius_px < 4 || pixels.size() < 60) return kUnknownBlur_px;
  double best = std::numeric_limits<double>::infinity(), best_blur_px = kUnknownBlur_px;
  for (double blur_px = 0.30; blur_px < 3.0; blur_px *= 1.05) {
    for (double shift_px = -0.8; shift_px <= 0.81; shift_px += 0.1) {
      const double value = misfit(pixels, blur_px, shift_px);
      if (value < best) best = value, best_blur_px = blur_px;
    }
  }
  return best_blur_px;
}

}  // namespace

std::optional<Eigen::Vector2d> pixel_of_sheet(const CameraModel& camera, const Pose& T_landmark_camera,
                                              const Eigen::Vector2d& point_m) {
  const Eigen::Vector3d point_camera_m = T_landmark_camera.inverse() * Eigen::Vector3d(point_m.x(), 0, point_m.y());
  if (point_camera_m.z() <= 1e-3) return std::nullopt;
  return camera.pixel_from_normalised(point_camera_m.head<2>() / point_camera_m.z());
}

std::optional<Eigen::Vector2d> sheet_of_pixel(const CameraModel& camera, const Pose& T_landmark_camera,
                                              const Eigen::Vector2d& pixel_px) {
  const auto point = camera.normalised_from_pixel(pixel_px);
  if (!point) return std::nullopt;
  const Eigen::Vector3d ray = T_landmark_camera.rotation * point->homogeneous();
  const Eigen::Vector3d& eye_m = T_landmark_camera.translation_m;
  const double scale = -eye_m.y() / ray.y();
  if (!(scale > 0) || !std::isfinite(scale)) return std::nullopt;
  return Eigen::Vector2d(eye_m.x() + scale * ray.x(), eye_m.z() + scale * ray.z());
}

std::optional<PictureQuality> measure_quality(const ImageView& luma, const CameraModel& camera,
                                              const LandmarkGeometry& landmark, const Pose& T_landmark_camera) {
  const Sight sight{luma, camera, landmark, T_landmark_camera};
  const double gap_m = landmark.ring_radius_m - landmark.dot_radius_m - landmark.centre_radius_m;
  const double between_m = landmark.centre_radius_m + gap_m / 2;
  const auto paper = grey_on_circles(sight, {between_m - gap_m / 8, between_m, between_m + gap_m / 8});
  const auto ink = grey_on_circles(
      sight, {0.05 * landmark.centre_radius_m, 0.3 * landmark.centre_radius_m, 0.6 * landmark.centre_radius_m});
  if (paper.size() < 8 || ink.size() < 4) return std::nullopt;
  const double contrast_lsb = median(paper) - median(ink);
  if (contrast_lsb < kMinContrast_lsb) return std::nullopt;
  return PictureQuality{contrast_lsb, measure_noise(sight), measure_blur(sight)};
}

}  // namespace ninedot::bench
