#include "tests/support/renderer_optics.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/contract.h"

namespace ninedot::test {
namespace {

// What a lens does to a normalised point: (x, y) -> radial * (x, y) + tangential. OpenCV documentation, "Camera
// Calibration and 3D Reconstruction"; plumb_bob is the rational model with a denominator of 1.
struct LensFactors {
  double radial;
  Eigen::Vector2d tangential;
};

LensFactors lens_factors(const Lens& lens, const Eigen::Vector2d& p) {
  const auto& k = lens.k;
  const double q = p.squaredNorm();
  double radial = 1 + q * (k[0] + q * (k[1] + q * k[4]));
  if (lens.model == LensModel::kRational) radial /= 1 + q * (k[5] + q * (k[6] + q * k[7]));
  return {radial,
          {2 * k[2] * p.x() * p.y() + k[3] * (q + 2 * p.x() * p.x()),
           k[2] * (q + 2 * p.y() * p.y()) + 2 * k[3] * p.x() * p.y()}};
}

double fisheye_angle(const Lens& lens, double theta_rad) {
  const double q = theta_rad * theta_rad;
  return theta_rad * (1 + q * (lens.k[0] + q * (lens.k[1] + q * (lens.k[2] + q * lens.k[3]))));
}

// Newton's method; the derivative is that of fisheye_angle.
Ray fisheye_ray(const Lens& lens, const Eigen::Vector2d& seen) {
  const double wanted_rad = seen.norm();
  if (wanted_rad < 1e-12) return {{seen.x(), seen.y(), 1}, true};
  double theta_rad = std::min(wanted_rad, 1.5);
  for (int i = 0; i < 30; ++i) {
    const double q = theta_rad * theta_rad;
    const double slope = 1 + q * (3 * lens.k[0] + q * (5 * lens.k[1] + q * (7 * lens.k[2] + q * 9 * lens.k[3])));
    const double step_rad = (wanted_rad - fisheye_angle(lens, theta_rad)) / slope;
    theta_rad += step_rad;
    if (!(theta_rad > 0 && theta_rad < std::numbers::pi)) return {};
    if (std::abs(step_rad) < 1e-13) {
      const double scale = std::sin(theta_rad) / wanted_rad;
      return {{seen.x() * scale, seen.y() * scale, std::cos(theta_rad)}, true};
    }
  }
  return {};
}

}  // namespace

Ray ray_of_pixel(const Lens& lens, double u_px, double v_px) {
  const Eigen::Vector2d seen((u_px - lens.cx_px) / lens.fx_px, (v_px - lens.cy_px) / lens.fy_px);
  if (lens.model == LensModel::kEquidistant) return fisheye_ray(lens, seen);
  Eigen::Vector2d p = seen;
  for (int i = 0; i < 100; ++i) {
    const LensFactors factors = lens_factors(lens, p);
    const Eigen::Vector2d next = (seen - factors.tangential) / factors.radial;
    const double change = (next - p).squaredNorm();
    p = next;
    if (change < 1e-26) return {{p.x(), p.y(), 1}, true};
  }
  return {};
}

Eigen::Matrix3d rotation_of(const CameraPose& pose) {
  const auto& q = pose.quaternion_wxyz;
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

Eigen::Vector2d pixel_of_wall_point(const Lens& lens, const CameraPose& pose, double x_m, double z_m) {
  const auto& c = pose.position_m;
  const Eigen::Vector3d ray = rotation_of(pose).transpose() * Eigen::Vector3d(x_m - c[0], -c[1], z_m - c[2]);
  EXPECTS(ray.z() > 0);
  Eigen::Vector2d seen = ray.head<2>() / ray.z();
  if (lens.model == LensModel::kEquidistant) {
    const double slope = seen.norm();
    if (slope > 0) seen *= fisheye_angle(lens, std::atan(slope)) / slope;
  } else {
    const LensFactors factors = lens_factors(lens, seen);
    seen = factors.radial * seen + factors.tangential;
  }
  return {lens.fx_px * seen.x() + lens.cx_px, lens.fy_px * seen.y() + lens.cy_px};
}

Eigen::Vector2d centroid_of_disc_px(const Lens& lens, const CameraPose& pose, const Disc& disc) {
  constexpr int kPoints = 720;
  const auto outline = [&](int i) {
    const double a_rad = 2 * std::numbers::pi * i / kPoints;
    return pixel_of_wall_point(lens, pose, disc.x_m + disc.radius_m * std::cos(a_rad),
                               disc.z_m + disc.radius_m * std::sin(a_rad));
  };
  // Green's theorem over a polygon, about its first point so that nothing large cancels.
  const Eigen::Vector2d origin = outline(0);
  Eigen::Vector2d moment(0, 0);
  double area = 0;
  Eigen::Vector2d p(0, 0);
  for (int i = 1; i <= kPoints; ++i) {
    const Eigen::Vector2d q = outline(i % kPoints) - origin;
    const double cross = p.x() * q.y() - p.y() * q.x();
    area += cross / 2;
    moment += cross / 6 * (p + q);
    p = q;
  }
  return origin + moment / area;
}

}  // namespace ninedot::test
