#include "tests/bench/crlb.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/renderer_optics.h"

namespace ninedot::bench {
namespace {

using test::Disc;
using test::Scene;

constexpr int kUnknowns = 9;           // pose, paper, ink, blur
constexpr double kFarOutside_px = 20;  // paper farther than this from every outline adds nothing to what is known of it
constexpr double kMinEigenvalue =
    1e-11;  // of the normalised information: below, some motion leaves the picture as it is
using Derivatives = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// A ray's hit on the wall, and its change with the pose.
struct Hit {
  Eigen::Vector2d at_m;
  Eigen::Matrix<double, 2, 6> per_pose;  // d(at) / d(position in S0, rotation vector in the camera frame)
};

class Geometry {
 public:
  explicit Geometry(const Scene& scene)
      : scene_(scene),
        R_(test::rotation_of(scene.camera)),
        centre_m_(scene.camera.position_m[0], scene.camera.position_m[1], scene.camera.position_m[2]) {
    if (scene.board.hidden_fraction > 0) board_offset_m_ = test::board_offset_m(scene.board, scene.sheets.front());
  }

  // at = (Cx - Cy Dx / Dy, Cz - Cy Dz / Dy) with D = R ray; turning by w changes D by R (w x ray).
  std::optional<Hit> hit(double u_px, double v_px) const {
    const test::Ray ray = test::ray_of_pixel(scene_.lens, u_px, v_px);
    if (!ray.valid) return std::nullopt;
    const Eigen::Vector3d d = R_ * ray.direction;
    if (d.y() >= -1e-9) return std::nullopt;
    const double sx = d.x() / d.y(), sz = d.z() / d.y(), reach = -centre_m_.y() / d.y();
    Eigen::Matrix<double, 2, 3> per_direction;
    per_direction << reach, -reach * sx, 0, 0, -reach * sz, reach;
    Hit hit;
    hit.at_m = {centre_m_.x() - centre_m_.y() * sx, centre_m_.z() - centre_m_.y() * sz};
    hit.per_pose.leftCols<3>() << 1, -sx, 0, 0, -sz, 1;
    hit.per_pose.rightCols<3>() = -per_direction * R_ * cross_matrix(ray.direction);
    return hit;
  }

  bool hidden(const Eigen::Vector2d& at_m) const {
    const auto& board = scene_.board;
    return board.hidden_fraction > 0 &&
           at_m.x() * std::cos(board.direction_rad) + at_m.y() * std::sin(board.direction_rad) > board_offset_m_;
  }

  const Eigen::Vector3d& centre_m() const { return centre_m_; }

 private:
  const Scene& scene_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d centre_m_;
  double board_offset_m_ = 0;
};

// The nearest outline: its signed distance from the spot, the direction in which it grows, and what is inside.
struct Outline {
  double distance_m = 1e9;
  double reflectance = 0;
  Eigen::Vector2d normal{1, 0};
};

Outline nearest_outline(const test::Sheet& sheet, const Eigen::Vector2d& at_m) {
  Outline nearest;
  for (const Disc& disc : sheet.discs) {
    const Eigen::Vector2d offset_m = at_m - Eigen::Vector2d(sheet.x_m + disc.x_m, sheet.z_m + disc.z_m);
    const double rho_m = offset_m.norm();
    if (rho_m - disc.radius_m >= nearest.distance_m) continue;
    nearest.distance_m = rho_m - disc.radius_m, nearest.reflectance = disc.reflectance;
    if (rho_m > 0) nearest.normal = offset_m / rho_m;
  }
  return nearest;
}

// The picture's part that can tell anything: around the projections of all outlines.
struct Window {
  int x0, y0, x1, y1;
};

Window window_of(const Scene& scene) {
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  const test::Sheet& sheet = scene.sheets.front();
  for (const Disc& disc : sheet.discs)
    for (int i = 0; i < 32; ++i) {
      const double a_rad = i * std::numbers::pi / 16;
      const Eigen::Vector2d p =
          test::pixel_of_wall_point(scene.lens, scene.camera, sheet.x_m + disc.x_m + disc.radius_m * std::cos(a_rad),
                                    sheet.z_m + disc.z_m + disc.radius_m * std::sin(a_rad));
      x0 = std::min(x0, p.x()), y0 = std::min(y0, p.y()), x1 = std::max(x1, p.x()), y1 = std::max(y1, p.y());
    }
  const double margin_px = 4 + 4 * scene.sensor.point_spread_px;
  const auto clamped = [](double value, int last) { return static_cast<int>(std::clamp(value, 0.0, last + 0.0)); };
  return {clamped(std::floor(x0 - margin_px), scene.lens.width_px),
          clamped(std::floor(y0 - margin_px), scene.lens.height_px),
          clamped(std::ceil(x1 + margin_px) + 1, scene.lens.width_px),
          clamped(std::ceil(y1 + margin_px) + 1, scene.lens.height_px)};
}

// Variance of one pixel in linear light.
double variance_of(const test::Sensor& sensor, double light) {
  const double grey = test::grey_from_light(light, sensor.tone);
  const double light_per_lsb = test::light_from_grey(std::min(grey + 0.5, 255.0), sensor.tone) -
                               test::light_from_grey(std::max(grey - 0.5, 0.0), sensor.tone);
  return sensor.noise_a * light + sensor.noise_b + light_per_lsb * light_per_lsb / 12;
}

}  // namespace

std::optional<PoseBound> cramer_rao_bound(const Scene& scene) {
  const Geometry geometry(scene);
  const test::Sheet& sheet = scene.sheets.front();
  const double clear = (1 - scene.haze.veil) * scene.light.level, veil = scene.haze.veil * scene.haze.level;
  const double paper = clear * sheet.reflectance + veil;
  const double blur_px = std::sqrt(scene.sensor.point_spread_px * scene.sensor.point_spread_px + 1.0 / 12);
  const Window window = window_of(scene);
  Information information = Information::Zero();
  for (int y = window.y0; y < window.y1; ++y)
    for (int x = window.x0; x < window.x1; ++x) {
      const auto hit = geometry.hit(x, y), right = geometry.hit(x + 0.5, y), left = geometry.hit(x - 0.5, y),
                 below = geometry.hit(x, y + 0.5), above = geometry.hit(x, y - 0.5);
      if (!hit || !right || !left || !below || !above || geometry.hidden(hit->at_m)) continue;
      const Outline outline = nearest_outline(sheet, hit->at_m);
      const double m_per_px =
          std::hypot(outline.normal.dot(right->at_m - left->at_m), outline.normal.dot(below->at_m - above->at_m));
      const double d = outline.distance_m / m_per_px / blur_px;  // in sigmas of the blur
      if (d * blur_px > kFarOutside_px) continue;
      const double ink = clear * outline.reflectance + veil;
      const double cover = 0.5 * std::erfc(d / std::numbers::sqrt2);
      const double density = std::exp(-d * d / 2) / std::sqrt(2 * std::numbers::pi);
      Derivatives j;
      j.head<6>() =
          (paper - ink) * density / (blur_px * m_per_px) * (outline.normal.transpose() * hit->per_pose).transpose();
      j[6] = 1 - cover, j[7] = cover, j[8] = (ink - paper) * density * d / blur_px;
      information += j * j.transpose() / variance_of(scene.sensor, paper + (ink - paper) * cover);
    }
  // Unknowns of metres, radians, light and px: brought to one scale before the inverse is judged.
  const Derivatives scale = information.diagonal().cwiseSqrt();
  if (scale.minCoeff() <= 0) return std::nullopt;
  const Information scaled = scale.cwiseInverse().asDiagonal() * information * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Information> eigen(scaled);
  if (eigen.eigenvalues()[0] < kMinEigenvalue) return std::nullopt;
  const Information unscaled = scale.cwiseInverse().asDiagonal() * eigen.eigenvectors();
  const Information covariance = unscaled * eigen.eigenvalues().cwiseInverse().asDiagonal() * unscaled.transpose();
  PoseBound bound;
  bound.covariance = covariance.topLeftCorner<6, 6>();
  bound.position_m = std::sqrt(bound.covariance.topLeftCorner<3, 3>().trace());
  bound.rotation_rad = std::sqrt(bound.covariance.bottomRightCorner<3, 3>().trace());
  const Eigen::Vector3d sight = geometry.centre_m().normalized();
  bound.along_m = std::sqrt(sight.dot(bound.covariance.topLeftCorner<3, 3>() * sight));
  return bound;
}

}  // namespace ninedot::bench
