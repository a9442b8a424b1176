#include "pose/ellipse_distance.h"

#include <algorithm>
#include <cmath>

namespace ninedot {

DistanceTilt exact_distance_tilt(double semi_major, double semi_minor, double radius_m) noexcept {
  // With u = (D / R)^2 the two relations give u^2 - (1 + 1/a^2) u + b^2 / a^4 = 0; the roots are real for all b <= a.
  const double a2 = semi_major * semi_major;
  const double half_sum = 0.5 * (1 + 1 / a2);
  const double product = semi_minor * semi_minor / (a2 * a2);
  const double u = half_sum + std::sqrt(std::max(0.0, half_sum * half_sum - product));
  const double cosine = semi_minor / (a2 * std::sqrt(u));
  return {radius_m * std::sqrt(u), std::acos(std::min(1.0, cosine))};
}

Result<double> image_distance_mm(double semi_major_px, double radius_mm, const DistanceScale& scale) noexcept {
  constexpr double kThreshold_mm = 1e-9;  // epsilon of the paper's algorithm
  constexpr int kMaxSteps = 200;          // each contracts by p2 p3 D^(p3 - 1) / Kmm: far below 1 for every lens
  const double f_mm = scale.focal_length_mm;
  double distance_mm = f_mm * radius_mm / (semi_major_px * scale.kmm_mm_per_px) + f_mm;  // (6)
  if (scale.p1 == 0) return distance_mm;
  for (int step = 0; step < kMaxSteps; ++step) {
    const double F_mm_per_px = scale.p1 + scale.p2 * std::pow(distance_mm, scale.p3);  // (9)
    if (!(F_mm_per_px > 0)) break;
    const double next_mm = f_mm * radius_mm / (semi_major_px * F_mm_per_px) + f_mm;  // (8)
    const double change_mm = std::abs(next_mm - distance_mm);
    distance_mm = next_mm;
    if (change_mm <= kThreshold_mm) return distance_mm;
  }
  return fail(Errc::kPoseDegenerate, "the distance refinement F(D') = p1 + p2 D'^p3 does not settle: check p1, p2, p3");
}

double tilt_from_axes_rad(double semi_major, double semi_minor) noexcept {
  return std::acos(std::min(1.0, semi_minor / semi_major));
}

}  // namespace ninedot
