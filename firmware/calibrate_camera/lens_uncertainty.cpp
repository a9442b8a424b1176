#include "calibrate_camera/lens_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate_camera/lens_parameters.h"
#include "calibrate_camera/lens_prior.h"
#include "geometry/camera_gradients.h"
#include "pose/outline_distance.h"

namespace ninedot {
namespace {

using ViewMatrix = Eigen::Matrix<double, kPoseUnknowns + 1, kPoseUnknowns + 1>;

/// What one view says on the lens.
struct ViewSay {
  Eigen::MatrixXd information;
  Eigen::VectorXd score;
};

/// Of all edges: moments of Cauchy's influence function.
struct InfluenceSums {
  double weight = 0, slope = 0, square = 0, edges = 0;
};

ViewSay say_of(std::span<const PlaneDisc> discs, const SheetView& view, const LensFit& fit, const ViewState& state,
               InfluenceSums& sums) {
  constexpr double c2 = kLoss_sigmas * kLoss_sigmas;
  const int count = parameter_count(fit.camera.model);
  Eigen::MatrixXd lens = Eigen::MatrixXd::Zero(count, count), mixed = Eigen::MatrixXd::Zero(count, kPoseUnknowns + 1);
  ViewMatrix own = ViewMatrix::Zero();
  Eigen::VectorXd lens_score = Eigen::VectorXd::Zero(count);
  Eigen::Matrix<double, kPoseUnknowns + 1, 1> own_score = Eigen::Matrix<double, kPoseUnknowns + 1, 1>::Zero();
  for (const EdgePoint& edge : view.edges) {
    const Result<OutlineDistance> seen =
        outline_distance(fit.camera, discs[edge.disc], state.T_camera_sheet, edge.at_px);
    if (!seen) continue;
    const double sigma_px = total_sigma_px(edge, fit.floor_px);
    const double residual = (seen->distance_px - state.offset_px) / sigma_px, s = residual * residual / c2;
    const double weight = 1 / (1 + s);
    const Eigen::VectorXd J_lens = seen->by_intrinsics.head(count).transpose() / sigma_px;
    Eigen::Matrix<double, kPoseUnknowns + 1, 1> J_own;
    J_own << seen->by_pose.transpose(), -1;
    J_own /= sigma_px;
    lens += weight * J_lens * J_lens.transpose();
    mixed += weight * J_lens * J_own.transpose();
    own += weight * J_own * J_own.transpose();
    lens_score += weight * residual * J_lens;
    own_score += weight * residual * J_own;
    sums.weight += weight, sums.slope += (1 - s) * weight * weight,
        sums.square += weight * weight * residual * residual;
    ++sums.edges;
  }
  own.diagonal() *= 1 + 1e-12;
  const Eigen::MatrixXd gain = own.ldlt().solve(mixed.transpose()).transpose();
  return {lens - gain * mixed.transpose(), lens_score - gain * own_score};
}

constexpr int kPixels = DirectionErrors::kColumns * DirectionErrors::kRows;

/// How pixels move when the camera turns about its axes: by x, y, z. \param point  z = 1
Eigen::Matrix<double, 2, 3> pixel_by_turn(const CameraModel& camera, const Eigen::Vector2d& point) {
  Eigen::Matrix2d px_per_ray;
  camera.pixel_from_normalised(point, &px_per_ray);
  const double x = point.x(), y = point.y();
  Eigen::Matrix<double, 2, 3> ray_by_turn;
  ray_by_turn << -x * y, 1 + x * x, -y, -1 - y * y, x * y, x;
  return px_per_ray * ray_by_turn;
}

}  // namespace

LensCovariance lens_covariance(std::span<const PlaneDisc> discs, std::span<const SheetView> views, const LensFit& fit) {
  InfluenceSums sums;
  std::vector<ViewSay> says;
  for (std::size_t i = 0; i < views.size(); ++i) says.push_back(say_of(discs, views[i], fit, fit.views[i], sums));
  const int count = parameter_count(fit.camera.model);
  Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(count, count);
  for (const ViewSay& say : says) seen += say.information;
  Eigen::MatrixXd information = seen;
  Eigen::VectorXd ignored;
  if (Eigen::MatrixXd prior; LensPrior(fit.camera).evaluate(parameters_of(fit.camera), ignored, &prior))
    information += prior.transpose() * prior;
  const Eigen::MatrixXd inverse =
      information.ldlt().solve(Eigen::MatrixXd::Identity(count, count)).selfadjointView<Eigen::Upper>();

  // A view's score is that of the errors less what the fit took of it: its expectation is I_v - I_v A^-1 I_v.
  double spread = 0, expected = 0;
  for (const ViewSay& say : says) {
    spread += say.score.dot(inverse * say.score);
    const Eigen::MatrixXd share = inverse * say.information;
    expected += share.trace() - (share * share).trace();
  }
  const double unknowns = count + static_cast<double>(views.size()) * (kPoseUnknowns + 1);
  const double lone = sums.edges > unknowns ? sums.square / (sums.edges - unknowns) : 1;
  const double mean_weight = sums.weight / std::max(1.0, sums.edges);
  const double by_views = expected > 0 ? spread / expected * mean_weight : lone;
  // The information was summed with weights; what the estimate's steps follow are the slopes of the influence function.
  const double slope_per_weight = sums.slope / std::max(1e-9, sums.weight);
  LensCovariance result;
  const double nominal = lone / mean_weight;
  const double factor = std::max(by_views, lone) / mean_weight;
  result.matrix = inverse * factor / (slope_per_weight * slope_per_weight);
  result.variance_factor = factor / nominal;
  return result;
}

Eigen::Vector2d DirectionErrors::pixel_px(int column, int row) const {
  return {(width_px - 1.0) * column / (kColumns - 1), (height_px - 1.0) * row / (kRows - 1)};
}

namespace {

/// Infinite where there is none.
double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::numeric_limits<double>::infinity();
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace

double DirectionErrors::median_px() const { return quantile(sigma_px, 0.5); }
double DirectionErrors::max_px() const { return quantile(sigma_px, 1); }

DirectionErrors direction_errors(const CameraModel& camera, const Eigen::MatrixXd& covariance) {
  DirectionErrors errors{camera.width_px, camera.height_px,
                         std::vector<double>(kPixels, std::numeric_limits<double>::infinity())};
  const Eigen::Index count = covariance.rows();
  Eigen::MatrixXd by_lens = Eigen::MatrixXd::Zero(Eigen::Index{2} * kPixels, count);
  Eigen::MatrixXd by_turn = Eigen::MatrixXd::Zero(Eigen::Index{2} * kPixels, 3);
  std::vector<bool> valid(kPixels, false);
  for (int i = 0; i < kPixels; ++i) {
    const Result<Eigen::Vector2d> point =
        camera.normalised_from_pixel(errors.pixel_px(i % DirectionErrors::kColumns, i / DirectionErrors::kColumns));
    if (!point) continue;
    valid[static_cast<std::size_t>(i)] = true;
    by_lens.middleRows<2>(Eigen::Index{2} * i) = pixel_by_intrinsics(camera, *point).leftCols(count);
    by_turn.middleRows<2>(Eigen::Index{2} * i) = pixel_by_turn(camera, *point);
  }
  // What is left once the turn that takes up most of it is taken off.
  by_lens -= by_turn * (by_turn.transpose() * by_turn).ldlt().solve(by_turn.transpose() * by_lens);
  for (int i = 0; i < kPixels; ++i) {
    if (!valid[static_cast<std::size_t>(i)]) continue;
    const Eigen::MatrixXd J = by_lens.middleRows<2>(Eigen::Index{2} * i);
    errors.sigma_px[static_cast<std::size_t>(i)] = std::sqrt(std::max(0.0, (J * covariance * J.transpose()).trace()));
  }
  return errors;
}

DirectionErrors direction_differences(const CameraModel& a, const CameraModel& b) {
  DirectionErrors errors{a.width_px, a.height_px,
                         std::vector<double>(kPixels, std::numeric_limits<double>::infinity())};
  Eigen::VectorXd off = Eigen::VectorXd::Zero(Eigen::Index{2} * kPixels);
  Eigen::MatrixXd by_turn = Eigen::MatrixXd::Zero(Eigen::Index{2} * kPixels, 3);
  std::vector<Eigen::Vector2d> points;
  std::vector<bool> valid(kPixels, false);
  for (int i = 0; i < kPixels; ++i) {
    const Eigen::Vector2d pixel_px = errors.pixel_px(i % DirectionErrors::kColumns, i / DirectionErrors::kColumns);
    const Result<Eigen::Vector2d> point = a.normalised_from_pixel(pixel_px);
    points.push_back(point.value_or(Eigen::Vector2d::Zero()));
    if (!point || !b.normalised_from_pixel(pixel_px)) continue;
    valid[static_cast<std::size_t>(i)] = true;
  }
  // Turns of some degrees at most, so Gauss and Newton's method needs few steps.
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int step = 0; step < 5; ++step) {
    for (int i = 0; i < kPixels; ++i) {
      if (!valid[static_cast<std::size_t>(i)]) continue;
      const Eigen::Vector2d turned = (R * points[static_cast<std::size_t>(i)].homogeneous()).hnormalized();
      off.segment<2>(Eigen::Index{2} * i) =
          b.pixel_from_normalised(turned) -
          errors.pixel_px(i % DirectionErrors::kColumns, i / DirectionErrors::kColumns);
      by_turn.middleRows<2>(Eigen::Index{2} * i) = pixel_by_turn(b, turned);
    }
    const Eigen::Vector3d turn_rad = (by_turn.transpose() * by_turn).ldlt().solve(-by_turn.transpose() * off);
    if (step < 4) R = exp_so3(turn_rad) * R;
  }
  for (int i = 0; i < kPixels; ++i)
    if (valid[static_cast<std::size_t>(i)])
      errors.sigma_px[static_cast<std::size_t>(i)] = off.segment<2>(Eigen::Index{2} * i).norm();
  return errors;
}

}  // namespace ninedot
