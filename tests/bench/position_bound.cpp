// grey = ink + (paper - ink) Phi(d / blur), d the signed distance of a pixel to the nearest outline: the distance from
// the disc's middle in the sheet, less its radius, divided by how fast that grows per pixel. Derivatives by the pose
// are central differences of d; those by paper, ink and blur are written out. Only pixels near an outline carry
// information on the pose.
#include "tests/bench/position_bound.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

namespace ninedot::bench {
namespace {

using Pose = Transform<frame::Landmark, frame::Camera>;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

struct View {
  const CameraModel& camera;
  const LandmarkGeometry& landmark;
};

/// Signed distance of a pixel to the outline of one disc [px], positive outside; NaN where the sheet is not seen.
double outline_distance_px(const View& view, const Pose& pose, std::size_t dot, const Eigen::Vector2d& pixel_px) {
  const auto radius_m = [&](double dx, double dy) {
    const auto point_m = sheet_of_pixel(view.camera, pose, pixel_px + Eigen::Vector2d(dx, dy));
    return point_m ? (*point_m - view.landmark.centre_m(dot)).norm() : std::nan("");
  };
  const Eigen::Vector2d per_px{radius_m(0.5, 0) - radius_m(-0.5, 0), radius_m(0, 0.5) - radius_m(0, -0.5)};
  return (radius_m(0, 0) - view.landmark.radius_m(dot)) / per_px.norm();
}

struct OutlinePixel {
  Eigen::Vector2d pixel_px;
  std::size_t dot;
};

/// All pixels within `reach_px` of an outline.
std::vector<OutlinePixel> find_outline_pixels(const View& view, const Pose& pose, double reach_px) {
  std::vector<OutlinePixel> pixels;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    Eigen::Vector2d low_px{1e9, 1e9}, high_px{-1e9, -1e9};
    for (int i = 0; i < 32; ++i) {
      const double a_rad = i * std::numbers::pi / 16;
      const Eigen::Vector2d rim_m = view.landmark.radius_m(dot) * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad));
      const auto pixel = pixel_of_sheet(view.camera, pose, view.landmark.centre_m(dot) + rim_m);
      if (!pixel) continue;
      low_px = low_px.cwiseMin(*pixel);
      high_px = high_px.cwiseMax(*pixel);
    }
    const auto first = [&](double low) { return std::max(0, static_cast<int>(low - reach_px)); };
    const int last_x = std::min(view.camera.width_px - 1, static_cast<int>(high_px.x() + reach_px) + 1);
    const int last_y = std::min(view.camera.height_px - 1, static_cast<int>(high_px.y() + reach_px) + 1);
    for (int y = first(low_px.y()); y <= last_y; ++y) {
      for (int x = first(low_px.x()); x <= last_x; ++x) {
        if (std::abs(outline_distance_px(view, pose, dot, {x, y})) <= reach_px) pixels.push_back({{x, y}, dot});
      }
    }
  }
  return pixels;
}

/// d(distance)/d(pose): position in S0 [m] and rotation vector in the camera frame [rad], the parameters of
/// pose/estimate.h.
Eigen::Matrix<double, 6, 1> distance_gradient(const View& view, const Pose& pose, const OutlinePixel& pixel) {
  const double step_m = 1e-5 * pose.translation_m.norm();
  constexpr double kStep_rad = 1e-5;
  Eigen::Matrix<double, 6, 1> gradient;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const auto moved = [&](double sign) {
      Pose other = pose;
      if (i < 3) {
        other.translation_m[i] += sign * step_m;
      } else {
        other.rotation = pose.rotation * exp_so3(sign * kStep_rad * Eigen::Vector3d::Unit(i - 3));
      }
      return outline_distance_px(view, other, pixel.dot, pixel.pixel_px);
    };
    gradient[i] = (moved(1) - moved(-1)) / (2 * (i < 3 ? step_m : kStep_rad));
  }
  return gradient;
}

}  // namespace

double position_bound_m(const CameraModel& camera, const LandmarkGeometry& landmark, const Pose& T_landmark_camera,
                        const PictureQuality& quality) {
  const View view{camera, landmark};
  const double reach_px = 4 * quality.blur_px + 1;
  Matrix9d information = Matrix9d::Zero();
  for (const OutlinePixel& pixel : find_outline_pixels(view, T_landmark_camera, reach_px)) {
    const double distance = outline_distance_px(view, T_landmark_camera, pixel.dot, pixel.pixel_px) / quality.blur_px;
    const double paper = 0.5 * (1 + std::erf(distance / std::numbers::sqrt2));
    const double per_distance =
        quality.contrast_lsb * std::exp(-distance * distance / 2) / std::sqrt(2 * std::numbers::pi);
    Vector9d row;
    row.head<6>() = per_distance / quality.blur_px * distance_gradient(view, T_landmark_camera, pixel);
    row[6] = paper;
    row[7] = 1 - paper;
    row[8] = -per_distance * distance / quality.blur_px;
    if (row.allFinite()) information += row * row.transpose();
  }
  // Metres and radians at very different scales: invert the matrix scaled to a unit diagonal.
  const Vector9d scale = information.diagonal().cwiseSqrt().cwiseMax(1e-12).cwiseInverse();
  const Eigen::LDLT<Matrix9d> solver(scale.asDiagonal() * information * scale.asDiagonal());
  if (solver.info() != Eigen::Success || !(solver.vectorD().array() > 1e-14).all()) return 0;
  const Matrix9d inverse = solver.solve(Matrix9d::Identity());
  const Matrix9d covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
  return quality.noise_lsb * std::sqrt(covariance.topLeftCorner<3, 3>().trace());
}

}  // namespace ninedot::bench
