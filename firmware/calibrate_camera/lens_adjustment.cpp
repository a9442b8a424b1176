// A view's pose is a step away from a pose that stays fixed while Ceres works, as in mapping/adjustment.cpp. A step to
// where the lens would have no inverse is refused by the cost functions, and Ceres takes a shorter one.
#include "calibrate_camera/lens_adjustment.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/contract.h"
#include "calibrate_camera/lens_parameters.h"
#include "calibrate_camera/lens_prior.h"
#include "pose/outline_distance.h"

namespace ninedot {
namespace {

constexpr int kViewUnknowns = kPoseUnknowns + 1;
/// As in view_fit.cpp.
constexpr double kOffset_px = 0.5;
/// Relative to the loss: what remains moves no parameter by a hundredth of its sigma.
constexpr double kSettled = 1e-10;
/// The median of |z| of a normal deviate.
constexpr double kMedianDeviate = 0.6745;

/// exp(r + d) = exp(J d) exp(r) for small d: the left Jacobian of rotations. J. Sola et al., "A micro Lie theory for
/// state estimation in robotics", 2018, equation (145).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& r) {
  Eigen::Matrix3d X;
  X << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  const double angle = r.norm();
  if (angle < 1e-5) return Eigen::Matrix3d::Identity() + X / 2;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / (angle * angle) * X +
         (angle - std::sin(angle)) / (angle * angle * angle) * X * X;
}

/// How far an edge is from its outline, in sigmas. Unknowns: the lens's parameters; step of the sheet, and the offset.
class EdgeCost final : public ceres::CostFunction {
 public:
  EdgeCost(const EdgePoint& edge, const PlaneDisc& disc, const CameraModel& camera, const ViewState& base,
           double floor_px)
      : edge_(edge), disc_(disc), camera_(camera), base_(base), sigma_px_(total_sigma_px(edge, floor_px)) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(parameter_count(camera.model));
    mutable_parameter_block_sizes()->push_back(kViewUnknowns);
  }

  bool Evaluate(const double* const* unknowns, double* residual, double** jacobians) const override {
    const int count = parameter_count(camera_.model);
    const CameraModel camera = with_parameters(camera_, Eigen::Map<const Eigen::VectorXd>(unknowns[0], count));
    const Eigen::Map<const Eigen::Matrix<double, kViewUnknowns, 1>> step(unknowns[1]);
    if (!(camera.fx_px > 0 && camera.fy_px > 0)) return false;
    const Eigen::Vector3d rotation_rad = step.head<3>() / kLever_m;
    CameraFromLandmark T = base_.T_camera_sheet;
    T.rotation = exp_so3(rotation_rad) * T.rotation;
    T.translation_m += step.segment<3>(3);
    const Result<OutlineDistance> seen = outline_distance(camera, disc_, T, edge_.at_px);
    if (!seen) return false;
    *residual = (seen->distance_px - step(6)) / sigma_px_;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr)
      Eigen::Map<Eigen::RowVectorXd>(jacobians[0], count) = seen->by_intrinsics.head(count) / sigma_px_;
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 1, kViewUnknowns>> J(jacobians[1]);
      J << seen->by_pose.head<3>() * left_jacobian(rotation_rad), seen->by_pose.tail<3>(), -1;
      J /= sigma_px_;
    }
    return true;
  }

 private:
  const EdgePoint& edge_;
  const PlaneDisc& disc_;
  const CameraModel& camera_;
  const ViewState& base_;
  double sigma_px_;
};

/// What is believed of the lens.
class LensPriorCost final : public ceres::CostFunction {
 public:
  explicit LensPriorCost(const CameraModel& camera) : prior_(camera), unknowns_(parameter_count(camera.model)) {
    set_num_residuals(static_cast<int>(prior_.count()));
    mutable_parameter_block_sizes()->push_back(unknowns_);
  }
  bool Evaluate(const double* const* unknowns, double* residuals, double** jacobians) const override {
    const bool asks_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    Eigen::VectorXd values;
    Eigen::MatrixXd jacobian;
    if (!prior_.evaluate(Eigen::Map<const Eigen::VectorXd>(unknowns[0], unknowns_), values,
                         asks_jacobian ? &jacobian : nullptr))
      return false;
    Eigen::Map<Eigen::VectorXd>(residuals, prior_.count()) = values;
    if (asks_jacobian)
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(jacobians[0], prior_.count(),
                                                                                         unknowns_) = jacobian;
    return true;
  }

 private:
  LensPrior prior_;
  int unknowns_;
};

/// What is believed of a view's offset.
class OffsetPriorCost final : public ceres::SizedCostFunction<1, kViewUnknowns> {
 public:
  bool Evaluate(const double* const* unknowns, double* residuals, double** jacobians) const override {
    residuals[0] = unknowns[0][kViewUnknowns - 1] / kOffset_px;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      std::fill_n(jacobians[0], kViewUnknowns, 0.0);
      jacobians[0][kViewUnknowns - 1] = 1 / kOffset_px;
    }
    return true;
  }
};

class Reporter final : public ceres::IterationCallback {
 public:
  explicit Reporter(const std::function<bool()>& go_on) : go_on_(go_on) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return go_on_() ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
  }

 private:
  const std::function<bool()>& go_on_;
};

}  // namespace

bool adjust_lens(std::span<const PlaneDisc> discs, std::span<const SheetView> views, LensFit& fit,
                 const AdjustLensOptions& options) {
  EXPECTS(views.size() == fit.views.size());
  Eigen::VectorXd lens = parameters_of(fit.camera);
  std::vector<Eigen::Matrix<double, kViewUnknowns, 1>> steps(views.size());
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::CauchyLoss loss(kLoss_sigmas);
  ceres::Problem problem(ownership);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t i = 0; i < views.size(); ++i) {
    steps[i] << Eigen::Matrix<double, kPoseUnknowns, 1>::Zero(), fit.views[i].offset_px;
    for (const EdgePoint& edge : views[i].edges) {
      if (!outline_distance(fit.camera, discs[edge.disc], fit.views[i].T_camera_sheet, edge.at_px)) continue;
      problem.AddResidualBlock(new EdgeCost(edge, discs[edge.disc], fit.camera, fit.views[i], fit.floor_px), &loss,
                               lens.data(), steps[i].data());
    }
    if (!problem.HasParameterBlock(steps[i].data())) continue;
    problem.AddResidualBlock(new OffsetPriorCost, nullptr, steps[i].data());
    ordering->AddElementToGroup(steps[i].data(), 0);
  }
  if (!problem.HasParameterBlock(lens.data())) return false;
  problem.AddResidualBlock(new LensPriorCost(fit.camera), nullptr, lens.data());
  ordering->AddElementToGroup(lens.data(), 1);

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.num_threads = 1;  // sums in one order: the same views give the same lens
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = kSettled;
  solver.parameter_tolerance = 0;
  solver.logging_type = ceres::SILENT;
  // Where a step's equations have no answer Ceres takes a shorter one, and glog would tell the user on each.
  FLAGS_minloglevel = google::GLOG_ERROR;
  Reporter reporter(options.go_on);
  if (options.go_on) solver.callbacks.push_back(&reporter);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable() || !lens.allFinite()) return false;

  fit.camera = with_parameters(fit.camera, lens);
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewState& state = fit.views[i];
    state.T_camera_sheet.rotation = exp_so3(steps[i].head<3>() / kLever_m) * state.T_camera_sheet.rotation;
    state.T_camera_sheet.translation_m += steps[i].segment<3>(3);
    state.offset_px = steps[i](6);
  }
  fit.loss = summary.final_cost;
  return true;
}

double unexplained_px(std::span<const PlaneDisc> discs, std::span<const SheetView> views, const LensFit& fit) {
  struct Off {
    double residual_px, sigma_px;
  };
  std::vector<Off> all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::vector<double> residuals_px = edge_residuals_px(fit.camera, discs, views[i], fit.views[i]);
    for (std::size_t e = 0; e < residuals_px.size(); ++e)
      if (std::isfinite(residuals_px[e])) all.push_back({residuals_px[e], views[i].edges[e].sigma_px});
  }
  if (all.empty()) return 0;
  std::vector<double> deviates(all.size());
  const auto median_deviate = [&](double floor_px) {
    std::ranges::transform(all, deviates.begin(), [&](const Off& off) {
      return std::abs(off.residual_px) / std::hypot(off.sigma_px, floor_px);
    });
    const auto middle = deviates.begin() + static_cast<std::ptrdiff_t>(deviates.size() / 2);
    std::nth_element(deviates.begin(), middle, deviates.end());
    return *middle;
  };
  if (median_deviate(0) <= kMedianDeviate) return 0;
  double low_px = 0, high_px = 100;
  for (int step = 0; step < 40; ++step) {
    const double middle_px = (low_px + high_px) / 2;
    (median_deviate(middle_px) > kMedianDeviate ? low_px : high_px) = middle_px;
  }
  return high_px;
}

}  // namespace ninedot
