#pragma once
/// Distance and tilt from the ring ellipse's semi-axes: (3) to (10), (20) and (21) of Martin & Adan, Pattern
/// Recognition 45 (2012) 578-595, and the exact relations of which these are the first terms.
#include "base/result.h"

namespace ninedot {

struct DistanceTilt {
  double distance_m = 0;    ///< D: from P9 to the optical centre
  double tilt_phi_rad = 0;  ///< between the line of sight to P9 and the sheet's normal, [0, pi/2]
};

/// Exact for a circle whose centre is on the optical axis: a = R / sqrt(D^2 - R^2 sin^2 phi), b = a^2 D cos(phi) / R.
/// D^2 is the larger root of a quadratic. For D >> R it is D = R / a (3) and cos(phi) = b / a (21).
/// \param semi_major, semi_minor  at f = 1 (z = 1), 0 < semi_minor <= semi_major
/// \param radius_m  of the circle
/// Memory: none. Threads: pure.
DistanceTilt exact_distance_tilt(double semi_major, double semi_minor, double radius_m) noexcept;

/// What (6) to (10) need. All > 0 but p2, p3.
struct DistanceScale {
  double focal_length_mm;  ///< f
  double kmm_mm_per_px;    ///< Kmm (7)
  double p1, p2, p3;       ///< F(D') = p1 + p2 D'^p3 (9), D' in mm; p1 = 0: no refinement
};

/// D' [mm] = f R / (a_s Kmm) + f (6), then D' = f R / (a_s F(D')) + f (8) by fixed-point iteration (10).
/// \param semi_major_px  a_s
/// \error kPoseDegenerate: the iteration leaves F > 0 or does not settle
/// Memory: none. Threads: pure.
Result<double> image_distance_mm(double semi_major_px, double radius_mm, const DistanceScale& scale) noexcept;

/// phi = acos(b / a) (21), for D >> R.
/// \param semi_major, semi_minor  a and b in one unit, whichever: only the ratio of them counts
/// Memory: none. Threads: pure.
double tilt_from_axes_rad(double semi_major, double semi_minor) noexcept;

}  // namespace ninedot
