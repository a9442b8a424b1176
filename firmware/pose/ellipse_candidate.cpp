/// The paper needs P9 in the middle of the picture, takes outline centres for pictures of centres, and D for large
/// against R. With a calibrated camera none of this is necessary: the rays are turned until P9 is on the axis, the
/// outline shifts follow from the pose of the pass before, and a and b give D and phi exactly.
#include "pose/ellipse_candidate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "geometry/disc.h"
#include "pose/ellipse_distance.h"
#include "pose/ellipse_parameters.h"
#include "pose/off_centre.h"
#include "pose/ring_ellipse.h"

namespace ninedot {
namespace {

static_assert(kContourPoints <= kRingDotCount);

constexpr int kMaxPasses = 40;       // measured: 2 to 6 with P9, up to 13 at level III (0.3 m, 75 deg)
constexpr double kRest = 1e-13;      // change at z = 1 at which passes end
constexpr double kMinCosine = 1e-4;  // of the tilt, in a division

/// The points of one fit; InlineVector takes trivially copyable types only, and Eigen's are not.
struct FitPoints {
  std::array<Eigen::Vector2d, kRingDotCount> points;
  std::size_t count = 0;
  void add(const Eigen::Vector2d& p) noexcept { points[count++] = p; }
  std::span<const Eigen::Vector2d> span() const noexcept { return {points.data(), count}; }
};

/// Moves points of the picture (z = 1) to where they would be, from P9, with P9 in the middle of the picture.
class Centring {
 public:
  Centring(const EllipseProblem& problem, const Eigen::Vector2d& p9) noexcept
      : literal_(problem.is_paper_calibrated()), fx_px_(problem.camera.fx_px), p9_(p9) {
    // (32, 33) work in pixels; square ones, so that one Kmm serves both axes.
    if (literal_)
      map_ = off_centre_correction(fx_px_ * p9, problem.calibration.cu, problem.calibration.cv);
    else
      map_ = centring_rotation(p9);
  }
  Eigen::Vector2d operator()(const Eigen::Vector2d& point) const noexcept {
    if (!literal_) return (map_ * point.homogeneous()).hnormalized();
    return (map_ * (fx_px_ * point).homogeneous()).head<2>() / fx_px_ - p9_;
  }

 private:
  bool literal_;
  double fx_px_;
  Eigen::Vector2d p9_;
  Eigen::Matrix3d map_;
};

FitPoints points_of_ellipse(const EllipseSight& sight, const EllipseCandidate& before,
                            const Centring& centring) noexcept {
  FitPoints fit;
  if (sight.occlusion == Occlusion::kLevelII) {
    for (const Eigen::Vector2d& point : sight.contour) fit.add(centring(point));
    return fit;
  }
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot)
    if (sight.seen[dot]) fit.add(centring(sight.outline_centres[dot] - before.outline_shift[dot]));
  return fit;
}

struct DistanceTiltImage {
  DistanceTilt exact;
  double image_distance_m;
};

/// D, phi and D' from the ellipse. \param radius_m  of the circle that the ellipse shows: the ring, or P9 (level II)
Result<DistanceTiltImage> distance_and_tilt(const EllipseProblem& problem, const RingEllipse& ellipse,
                                            double radius_m) noexcept {
  if (!problem.is_paper_calibrated()) {
    const DistanceTilt exact = exact_distance_tilt(ellipse.semi_major, ellipse.semi_minor, radius_m);
    return DistanceTiltImage{exact, exact.distance_m + kUnitFocalLength_m};
  }
  // Level II: P9's semi-axis, scaled by R over its radius, stands for the ring's; R over a_s stays the same.
  const EllipseCalibration& c = problem.calibration;
  const DistanceScale scale{problem.camera.fx_px * c.kmm_mm_per_px, c.kmm_mm_per_px, c.p1, c.p2, c.p3};
  NINEDOT_TRY(const double image_mm,
              image_distance_mm(ellipse.semi_major * problem.camera.fx_px, 1000 * radius_m, scale));
  return DistanceTiltImage{
      {(image_mm - scale.focal_length_mm) / 1000, tilt_from_axes_rad(ellipse.semi_major, ellipse.semi_minor)},
      image_mm / 1000};
}

/// Turns of half a circle added to `swing_rad` until it is nearest to `near_rad`: which end of the axis is meant.
double oriented_swing_rad(double swing_rad, double near_rad) noexcept {
  return swing_rad + std::numbers::pi * std::round((near_rad - swing_rad) / std::numbers::pi);
}

/// (22) to (25) for all visible ring dots: Pk, at the angle alpha_k from P1, is seen at x' = -R cos(alpha_k + theta),
/// z' = -R cos(phi) sin(alpha_k + theta) from P9, so theta = atan2(-z' / cos(phi), -x') - alpha_k; alpha = 0, pi, pi/2
/// and 3 pi/2 are the paper's P1, P5, P3 and P7. The mean is weighted: errors of z' count 1 / cos(phi) times as much as
/// those of x'.
double pan_theta_rad(const EllipseSight& sight, const EllipseCandidate& before, const Centring& centring,
                     double swing_rad, double tilt_phi_rad) noexcept {
  const double cosine = std::max(kMinCosine, std::cos(tilt_phi_rad));
  double sum_cos = 0, sum_sin = 0;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
    if (!sight.seen[dot]) continue;
    const Eigen::Vector2d at =
        to_ellipse_axes(centring(sight.outline_centres[dot] - before.outline_shift[dot]), swing_rad);
    const double beta_rad = std::atan2(-at.y() / cosine, -at.x());
    const double along = std::cos(beta_rad) / cosine, across = std::sin(beta_rad);
    const double weight = 1 / (along * along + across * across);
    const double theta_rad = beta_rad - static_cast<double>(dot) * std::numbers::pi / 4;
    sum_cos += weight * std::cos(theta_rad);
    sum_sin += weight * std::sin(theta_rad);
  }
  return std::atan2(sum_sin, sum_cos);
}

/// Outline shifts, and P9 where it is hidden, as the candidate's pose predicts them. Returns the largest change.
double predict_outlines(const EllipseProblem& problem, const EllipseSight& sight, const EllipseCandidate& before,
                        EllipseCandidate& candidate) noexcept {
  const auto T_camera_landmark = candidate.T_landmark_camera.inverse();
  double change = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d centre_m = problem.landmark.centre_m(dot);
    candidate.outline_shift[dot] = project_disc_centre(T_camera_landmark, centre_m, problem.landmark.radius_m(dot)) -
                                   project_plane_point(T_camera_landmark, centre_m);
    change = std::max(change, (candidate.outline_shift[dot] - before.outline_shift[dot]).norm());
  }
  return std::max(change, sight.seen[kCentreDot] ? 0 : (candidate.p9 - before.p9).norm());
}

/// Where P9 is seen when it is hidden: the middle of the circle whose picture is the ellipse. In the picture centred on
/// P9 the ellipse's centre lies R^2 sin(phi) cos(phi) / (D^2 - R^2 sin^2(phi)) from it towards the nearer side.
Eigen::Vector2d hidden_p9(const EllipseProblem& problem, const RingEllipse& ellipse, const DistanceTilt& at,
                          double swing_rad, const Eigen::Vector2d& p9) noexcept {
  const double R = problem.landmark.ring_radius_m;
  const double s = std::sin(at.tilt_phi_rad), c = std::cos(at.tilt_phi_rad);
  const double shift = -R * R * s * c / (at.distance_m * at.distance_m - R * R * s * s);  // along z'
  const Eigen::Vector2d z_axis(std::cos(swing_rad), std::sin(swing_rad));                 // z' as (right, down)
  const Eigen::Vector2d centred = ellipse.centre - shift * z_axis;
  return (centring_rotation(p9).transpose() * centred.homogeneous()).hnormalized();
}

}  // namespace

Result<EllipseCandidate> start_candidate(const EllipseProblem& problem, const EllipseSight& sight) noexcept {
  EllipseCandidate start;
  for (Eigen::Vector2d& shift : start.outline_shift) shift.setZero();
  FitPoints ring;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot)
    if (sight.seen[dot]) ring.add(sight.outline_centres[dot]);
  start.p9 = sight.outline_centres[kCentreDot];
  if (!sight.seen[kCentreDot]) {
    NINEDOT_TRY(const RingEllipse ellipse, fit_ring_ellipse(ring.span()));
    start.p9 = ellipse.centre;
  }
  const Centring centring(problem, start.p9);
  NINEDOT_TRY(const RingEllipse ellipse, fit_ring_ellipse(points_of_ellipse(sight, start, centring).span()));
  start.oriented_swing_rad = ellipse.swing_psi_rad;
  return start;
}

Result<EllipseCandidate> improve_candidate(const EllipseProblem& problem, const EllipseSight& sight,
                                           const EllipseCandidate& before) noexcept {
  EllipseCandidate next = before;
  if (sight.seen[kCentreDot]) next.p9 = sight.outline_centres[kCentreDot] - before.outline_shift[kCentreDot];
  const Centring centring(problem, next.p9);
  NINEDOT_TRY(const RingEllipse ellipse, fit_ring_ellipse(points_of_ellipse(sight, before, centring).span()));
  const bool from_p9 = sight.occlusion == Occlusion::kLevelII;
  const double radius_m = from_p9 ? problem.landmark.centre_radius_m : problem.landmark.ring_radius_m;
  NINEDOT_TRY(const DistanceTiltImage at, distance_and_tilt(problem, ellipse, radius_m));
  next.image_distance_m = at.image_distance_m;
  next.oriented_swing_rad = oriented_swing_rad(ellipse.swing_psi_rad, before.oriented_swing_rad);
  const double theta_rad = pan_theta_rad(sight, before, centring, next.oriented_swing_rad, at.exact.tilt_phi_rad);
  next.T_landmark_camera =
      pose_from_parameters(next.oriented_swing_rad, at.exact.tilt_phi_rad, theta_rad, at.exact.distance_m, next.p9);
  if (!sight.seen[kCentreDot] && !problem.is_paper_calibrated())
    next.p9 = hidden_p9(problem, ellipse, at.exact, next.oriented_swing_rad, next.p9);
  return next;
}

Result<EllipseCandidate> solve_candidate(const EllipseProblem& problem, const EllipseSight& sight,
                                         const EllipseCandidate& start) noexcept {
  NINEDOT_TRY(EllipseCandidate candidate, improve_candidate(problem, sight, start));
  if (problem.is_paper_calibrated()) return candidate;
  EllipseCandidate before = start;
  for (int pass = 0; pass < kMaxPasses && predict_outlines(problem, sight, before, candidate) > kRest; ++pass) {
    before = candidate;
    NINEDOT_TRY(candidate, improve_candidate(problem, sight, before));
  }
  return candidate;
}

OutlineResiduals outline_residuals_px(const EllipseProblem& problem, const EllipseSight& sight,
                                      const EllipseCandidate& candidate) noexcept {
  const auto T_camera_landmark = candidate.T_landmark_camera.inverse();
  OutlineResiduals residuals_px = OutlineResiduals::Zero();
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!sight.seen[dot]) continue;
    const Eigen::Vector2d predicted =
        project_disc_centre(T_camera_landmark, problem.landmark.centre_m(dot), problem.landmark.radius_m(dot));
    residuals_px.col(static_cast<Eigen::Index>(dot)) = problem.camera.pixel_from_normalised(predicted) -
                                                       problem.camera.pixel_from_normalised(sight.outline_centres[dot]);
  }
  return residuals_px;
}

}  // namespace ninedot
