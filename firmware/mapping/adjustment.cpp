// Every unknown place is a step of six numbers away from a place that stays fixed while Ceres works: plain vectors, and
// derivatives of three products. Afterwards the steps are taken.
#include "mapping/adjustment.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "base/contract.h"
#include "base/units.h"
#include "mapping/chi_square.h"

namespace ninedot {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Block = Eigen::Matrix<double, 2 * static_cast<int>(kDotCount), 6, Eigen::RowMajor>;

/// Nearer than this before the optical centre nothing is seen; it keeps the projection finite. [m]
constexpr double kNearest_m = 1e-3;
/// What a surveyed place is believed to at most.
constexpr double kExact_m = 1e-5, kExact_rad = 0.01 * kRadPerDeg;
/// Relative to the loss: what remains moves no place by a hundredth of its sigma.
constexpr double kSettled = 1e-9;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// exp(r + d) = exp(r) exp(J d) for small d: the right Jacobian of rotations. J. Sola et al., "A micro Lie theory for
/// state estimation in robotics", 2018, equation (143); the left one is its transpose.
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& r) {
  const double angle = r.norm();
  const Eigen::Matrix3d X = cross_matrix(r);
  if (angle < 1e-5) return Eigen::Matrix3d::Identity() - X / 2;
  return Eigen::Matrix3d::Identity() - (1 - std::cos(angle)) / (angle * angle) * X +
         (angle - std::sin(angle)) / (angle * angle * angle) * X * X;
}

/// What a turn of the camera that all of a landmark's dots share takes out of their distances: with the dots' own
/// sigmas as the unit, (1 + T T^T)^-1/2 = 1 - T K T^T, where T is how they move per sigma of the turn.
class SharedTurn {
 public:
  SharedTurn(const LandmarkSighting& seen, const std::array<Eigen::Matrix2d, kDotCount>& root) {
    if (!(seen.turn_sigma_rad > 0)) return;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      const Eigen::Vector3d ray = seen.dots[dot].ray.homogeneous();
      Eigen::Matrix<double, 2, 3> J_ray;
      J_ray << 1, 0, -ray.x(), 0, 1, -ray.y();
      T_.middleRows<2>(2 * static_cast<Eigen::Index>(dot)) =
          seen.turn_sigma_rad * root[dot] * J_ray * cross_matrix(ray);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(T_.transpose() * T_);
    const Eigen::Array3d held = eigen.eigenvalues().array().max(std::numeric_limits<double>::min());
    const Eigen::Vector3d share = (1 - (1 + held).rsqrt()) / held;
    TK_ = T_ * eigen.eigenvectors() * share.asDiagonal() * eigen.eigenvectors().transpose();
  }

  /// \param columns  residuals, or their derivatives
  template <typename Columns>
  void take_out(Columns&& columns) const {
    columns -= TK_ * (T_.transpose() * columns).eval();
  }

 private:
  using Turns = Eigen::Matrix<double, 2 * static_cast<int>(kDotCount), 3>;
  Turns T_ = Turns::Zero(), TK_ = Turns::Zero();
};

/// Distances of the dots, predicted minus seen, in their own sigmas. Unknowns: steps of the camera and of the landmark.
class SightingCost final : public ceres::SizedCostFunction<2 * static_cast<int>(kDotCount), 6, 6> {
 public:
  SightingCost(const LandmarkSighting& seen, const WorldFromCamera& camera, const WorldFromLandmark& place,
               const LandmarkGeometry& geometry)
      : seen_(seen), camera_(camera), place_(place), geometry_(geometry), root_(roots(seen)), turn_(seen, root_) {}

  bool Evaluate(const double* const* steps, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Vector6> camera_step(steps[0]), place_step(steps[1]);
    const WorldFromCamera camera = moved_by(camera_, camera_step);
    const WorldFromLandmark place = moved_by(place_, place_step);
    const Eigen::Matrix3d R_camera_world = camera.rotation.transpose();
    const Eigen::Matrix3d J_camera = right_jacobian(camera_step.tail<3>());
    const Eigen::Matrix3d J_place = right_jacobian(place_step.tail<3>()).transpose();
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      const auto row = 2 * static_cast<Eigen::Index>(dot);
      Eigen::Map<Eigen::Vector2d> residual(residuals + row);
      const Eigen::Vector2d on_sheet_m = geometry_.centre_m(dot);
      const Eigen::Vector3d from_middle = place.rotation * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
      Eigen::Vector3d p = R_camera_world * (from_middle + place.translation_m - camera.translation_m);
      const bool is_before = p.z() > kNearest_m;
      if (!is_before) p.z() = kNearest_m;  // a long way off, whatever direction that is in
      residual = root_[dot] * (p.hnormalized() - seen_.dots[dot].ray);
      if (jacobians == nullptr) continue;
      Eigen::Matrix<double, 2, 3> J_ray;
      J_ray << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z();
      J_ray = (is_before ? 1 / p.z() : 0.0) * (root_[dot] * J_ray).eval();
      if (jacobians[0] != nullptr)
        Eigen::Map<Block>(jacobians[0]).middleRows<2>(row) << -J_ray * R_camera_world,
            J_ray * cross_matrix(p) * J_camera;
      if (jacobians[1] != nullptr)
        Eigen::Map<Block>(jacobians[1]).middleRows<2>(row) << J_ray * R_camera_world,
            -J_ray * R_camera_world * cross_matrix(from_middle) * J_place;
    }
    turn_.take_out(Eigen::Map<Eigen::Vector<double, 2 * static_cast<int>(kDotCount)>>(residuals));
    for (int block = 0; jacobians != nullptr && block < 2; ++block)
      if (jacobians[block] != nullptr) turn_.take_out(Eigen::Map<Block>(jacobians[block]));
    return true;
  }

 private:
  using Roots = std::array<Eigen::Matrix2d, kDotCount>;

  /// W = U^T U
  static Roots roots(const LandmarkSighting& seen) {
    Roots root;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) root[dot] = seen.dots[dot].information.llt().matrixU();
    return root;
  }

  const LandmarkSighting& seen_;
  const WorldFromCamera& camera_;
  const WorldFromLandmark& place_;
  const LandmarkGeometry& geometry_;
  const Roots root_;
  const SharedTurn turn_;
};

/// How far a landmark is from where it was surveyed, in sigmas.
class SurveyCost final : public ceres::SizedCostFunction<6, 6> {
 public:
  SurveyCost(const MappedLandmark& surveyed, const WorldFromLandmark& place)
      : surveyed_(surveyed), place_(place), root_(survey_information(surveyed).llt().matrixU()) {}

  bool Evaluate(const double* const* steps, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Vector6> step(steps[0]);
    const Vector6 off = step_between(surveyed_.T_world_landmark, moved_by(place_, step));
    Eigen::Map<Vector6>{residuals} = root_ * off;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    // log(exp(d) exp(off)) for small d: the inverse of the left Jacobian at `off`.
    PlaceCovariance J = PlaceCovariance::Identity();
    J.bottomRightCorner<3, 3>() =
        right_jacobian(off.tail<3>()).transpose().inverse() * right_jacobian(step.tail<3>()).transpose();
    Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>{jacobians[0]} = root_ * J;
    return true;
  }

 private:
  const MappedLandmark& surveyed_;
  const WorldFromLandmark& place_;
  const PlaceCovariance root_;
};

class Reporter final : public ceres::IterationCallback {
 public:
  explicit Reporter(const std::function<void()>& progress) : progress_(progress) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    progress_();
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const std::function<void()>& progress_;
};

/// \return  null where nothing is to lose its influence
std::unique_ptr<ceres::LossFunction> loss_for(int freedoms, double tolerance) {
  if (std::isinf(tolerance)) return nullptr;
  return std::make_unique<ceres::CauchyLoss>(std::sqrt(tolerance * chi2_limit(freedoms)));
}

}  // namespace

PlaceCovariance survey_information(const MappedLandmark& surveyed) noexcept {
  PlaceCovariance covariance = surveyed.covariance;
  covariance.diagonal().head<3>().array() += kExact_m * kExact_m;
  covariance.diagonal().tail<3>().array() += kExact_rad * kExact_rad;
  return covariance.inverse();
}

double chi2_of_survey(const NetworkLandmark& landmark) noexcept {
  EXPECTS(landmark.surveyed.has_value());
  const PlaceStep off = step_between(landmark.surveyed->T_world_landmark, landmark.place);
  return off.dot(survey_information(*landmark.surveyed) * off);
}

double adjust(SightingNetwork& network, const AdjustmentOptions& options) {
  std::vector<Vector6> camera_steps(network.frames.size(), Vector6::Zero());
  std::vector<Vector6> place_steps(network.landmarks.size(), Vector6::Zero());
  ceres::Problem problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const NetworkSighting& sighting : network.sightings) {
    if (!network.counts(sighting)) continue;
    double* const camera = camera_steps[sighting.frame].data();
    double* const place = place_steps[sighting.landmark].data();
    const NetworkLandmark& landmark = network.landmarks[sighting.landmark];
    problem.AddResidualBlock(
        new SightingCost(*sighting.seen, network.frames[sighting.frame].camera, landmark.place, network.geometry),
        loss_for(SightingNetwork::freedoms_of(sighting), options.tolerance).release(), camera, place);
    ordering->AddElementToGroup(camera, 0);
    ordering->AddElementToGroup(place, 1);
    if (landmark.exact) problem.SetParameterBlockConstant(place);
  }
  for (std::size_t i = 0; i < network.landmarks.size(); ++i) {
    const NetworkLandmark& landmark = network.landmarks[i];
    if (!landmark.surveyed || !landmark.placed || !problem.HasParameterBlock(place_steps[i].data())) continue;
    problem.AddResidualBlock(new SurveyCost(*landmark.surveyed, landmark.place),
                             loss_for(6, options.tolerance).release(), place_steps[i].data());
  }
  if (problem.NumResidualBlocks() == 0) return 0;

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.num_threads = 1;  // by several sums depend on who comes first; and most of the time is one factorisation's
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = kSettled;
  solver.parameter_tolerance = 0;
  solver.logging_type = ceres::SILENT;
  Reporter reporter(options.progress);
  if (options.progress) solver.callbacks.push_back(&reporter);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);

  for (std::size_t i = 0; i < network.frames.size(); ++i)
    network.frames[i].camera = moved_by(network.frames[i].camera, camera_steps[i]);
  for (std::size_t i = 0; i < network.landmarks.size(); ++i)
    network.landmarks[i].place = moved_by(network.landmarks[i].place, place_steps[i]);
  return summary.final_cost;
}

}  // namespace ninedot
