/// Both sides to which the sheet may lean are solved in closed form; the dots' centres choose. The paper looks at one
/// of them only, P9, which perspective shifts along the minor axis; the ring's dots shift as well and are as good a
/// witness.
#include "pose/ellipse_solver.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pose/ellipse_candidate.h"
#include "pose/ellipse_parameters.h"
#include "pose/ellipse_sight.h"

namespace ninedot {
namespace {

/// Sigma of a dot's centre per axis before the residual has spoken [px]: a thresholded centroid of 6 to 12 px in
/// diameter (measured: 0.062 to 0.091), rounded up. Counts as much as kPriorFreedoms residuals.
constexpr double kCentreSigma_px = 0.1;
constexpr double kPriorFreedoms = 4;
constexpr double kPoseFreedoms = 6;
constexpr double kTiny_px2 = 1e-12;  // keeps a division finite

/// Squared residual that a small turn of the camera, which shifts all dots alike, can't remove: the witness for the
/// side. Without this, the error of P9's centre, on which both poses are hung up, weighs on the ring's dots and drowns
/// it.
double squared_shape_residual_px2(const EllipseProblem& problem, const EllipseSight& sight,
                                  const EllipseCandidate& candidate) noexcept {
  const OutlineResiduals residuals_px = outline_residuals_px(problem, sight, candidate);
  const Eigen::Vector2d sum_px = residuals_px.rowwise().sum();
  return std::max(0.0, residuals_px.squaredNorm() - sum_px.squaredNorm() / sight.seen_count);
}

/// Scatter of the pose when the seen coordinates move by sigma, one after the other, to either side. Squares of both
/// moves are averaged, not their difference: at a frontal view acos makes both moves go to the same side.
class Scatter {
 public:
  Scatter(const EllipseProblem& problem, const EllipseSight& sight, const EllipseCandidate& at) noexcept
      : problem_(problem), sight_(sight), at_(at), residuals_px_(outline_residuals_px(problem, sight, at)) {}

  /// \param coordinate  of `sight()`; changed and restored
  void add(double& coordinate, double sigma) noexcept {
    const double middle = coordinate;
    for (const double sign : {-1.0, 1.0}) {
      coordinate = middle + sign * sigma;
      const auto moved = solve_again();
      if (!moved) continue;
      Vector6d change;
      change << moved->T_landmark_camera.translation_m - at_.T_landmark_camera.translation_m,
          log_so3(at_.T_landmark_camera.rotation.transpose() * moved->T_landmark_camera.rotation);
      covariance_ += 0.5 * change * change.transpose();
      squared_residual_px2_ += 0.5 * (outline_residuals_px(problem_, sight_, *moved) - residuals_px_).squaredNorm();
    }
    coordinate = middle;
  }
  EllipseSight& sight() noexcept { return sight_; }
  const Matrix6d& covariance() const noexcept { return covariance_; }
  /// Squared residual to expect from the coordinates' sigmas alone.
  double squared_residual_px2() const noexcept { return squared_residual_px2_; }

 private:
  /// The outline shifts hardly change; P9, where it is hidden, needs a pass of its own.
  Result<EllipseCandidate> solve_again() const noexcept {
    NINEDOT_TRY(const EllipseCandidate moved, improve_candidate(problem_, sight_, at_));
    return sight_.occlusion == Occlusion::kLevelIII ? improve_candidate(problem_, sight_, moved) : moved;
  }

  const EllipseProblem& problem_;
  EllipseSight sight_;
  const EllipseCandidate& at_;
  OutlineResiduals residuals_px_;
  Matrix6d covariance_ = Matrix6d::Zero();
  double squared_residual_px2_ = 0;
};

/// Covariance for centres of kCentreSigma_px, scaled by what the residual says about that sigma. The expected residual
/// comes from the same scatter, because this method does not minimise it.
Matrix6d pose_covariance(const EllipseProblem& problem, const EllipseSight& sight, const EllipseCandidate& at,
                         double squared_residual_px2) noexcept {
  const double sigma_x = kCentreSigma_px / problem.camera.fx_px, sigma_y = kCentreSigma_px / problem.camera.fy_px;
  Scatter scatter(problem, sight, at);
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!sight.seen[dot]) continue;
    scatter.add(scatter.sight().outline_centres[dot].x(), sigma_x);
    scatter.add(scatter.sight().outline_centres[dot].y(), sigma_y);
  }
  if (sight.occlusion == Occlusion::kLevelII) {
    // The centre of n outline points with radial errors s has the variance 2 s^2 / n per axis: s = sigma sqrt(n / 2).
    const double factor = std::sqrt(kContourPoints / 2.0);
    for (Eigen::Vector2d& point : scatter.sight().contour) {
      scatter.add(point.x(), factor * sigma_x);
      scatter.add(point.y(), factor * sigma_y);
    }
  }
  const double freedoms = std::max(0.0, 2.0 * sight.seen_count - kPoseFreedoms);
  const double ratio = squared_residual_px2 / std::max(scatter.squared_residual_px2(), kTiny_px2);
  return scatter.covariance() * ((kPriorFreedoms + freedoms * ratio) / (kPriorFreedoms + freedoms));
}

}  // namespace

EllipseSolver::EllipseSolver(const CameraModel& camera, const LandmarkGeometry& landmark,
                             const EllipseCalibration& calibration)
    : camera_(camera), landmark_(landmark), calibration_(calibration) {}

Result<PoseCandidates> EllipseSolver::solve(const LandmarkObservation& seen) const noexcept {
  const EllipseProblem problem{camera_, landmark_, calibration_};
  NINEDOT_TRY(const EllipseSight sight, make_ellipse_sight(camera_, seen));
  NINEDOT_TRY(EllipseCandidate side, start_candidate(problem, sight));
  NINEDOT_TRY(EllipseCandidate best, solve_candidate(problem, sight, side));
  side.oriented_swing_rad += std::numbers::pi;
  NINEDOT_TRY(EllipseCandidate other, solve_candidate(problem, sight, side));
  double best_px2 = squared_shape_residual_px2(problem, sight, best);
  double other_px2 = squared_shape_residual_px2(problem, sight, other);
  if (other_px2 < best_px2) {
    std::swap(best, other);
    std::swap(best_px2, other_px2);
  }

  PoseCandidates candidates;
  PoseCandidate chosen, mirror;
  PoseEstimate& estimate = chosen.pose;
  estimate.T_landmark_camera = best.T_landmark_camera;
  const double residual_px2 = outline_residuals_px(problem, sight, best).squaredNorm();
  estimate.covariance = pose_covariance(problem, sight, best, residual_px2);
  estimate.rms_px = std::sqrt(residual_px2 / sight.seen_count);
  estimate.dots_used = sight.seen_count;
  estimate.occlusion_level = static_cast<int>(sight.occlusion);
  estimate.ellipse = ellipse_parameters(best.T_landmark_camera, camera_, landmark_);
  estimate.ellipse.image_distance_m = best.image_distance_m;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) chosen.visible_share[dot] = sight.seen[dot] ? 1 : 0;

  mirror.pose.T_landmark_camera = other.T_landmark_camera;
  const double variance_px2 = std::max(kCentreSigma_px * kCentreSigma_px, best_px2 / (2.0 * sight.seen_count));
  mirror.chi2_above = (other_px2 - best_px2) / variance_px2;
  mirror.refined = false;
  (void)candidates.list.try_push_back(chosen);
  (void)candidates.list.try_push_back(mirror);
  return candidates;
}

}  // namespace ninedot
