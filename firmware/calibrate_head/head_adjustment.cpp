// Turns are steps away from turns that stay fixed while Ceres works, as in mapping/adjustment.cpp; afterwards they are
// taken. Derivatives are Ceres's own, by dual numbers: the chain is short, and there is time.
#include "calibrate_head/head_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "base/units.h"
#include "geometry/euler_angles.h"
#include "mapping/chi_square.h"
#include "world/sighting_fit.h"

namespace ninedot {
namespace {

/// Nearer than this before the optical centre nothing is seen; it keeps the projection finite. [m]
constexpr double kNearest_m = 1e-3;
/// The anchor is a choice, and exact: far below what any angle is known to. [rad]
constexpr double kAnchored_rad = 1e-8;
/// A play of more than this would be a broken gear; where no side is known it keeps the lag at 0. [rad]
constexpr double kMostLag_rad = 5 * kRadPerDeg, kNoLag_rad = 1e-9;
/// A tie that is so many spreads off loses its influence.
constexpr double kTieLoss = 3;
/// Relative to the loss: what remains moves nothing by a hundredth of its sigma.
constexpr double kSettled = 1e-10;

constexpr int kPlaceUnknowns = 6, kDotResiduals = 2 * static_cast<int>(kDotCount);

/// What a place's and the camera's steps begin from.
struct Fixed {
  Eigen::Matrix3d R_tilted_camera;
  Eigen::Vector3d tilt_axis_m;
};

/// Distances of the dots, predicted minus seen, in sigmas. Unknowns: the stop's angles, chain, skew, place.
class SightingCost {
 public:
  SightingCost(const StopSighting& sighting, const HeadNetwork& network, const Fixed& fixed)
      : seen_(*sighting.seen),
        place_(network.places[sighting.place].T_foot_landmark),
        landmark_(network.landmark),
        fixed_(fixed) {
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      root_[dot] = (seen_.dots[dot].information / network.variance_factor).llt().matrixU();  // W = U^T U
  }

  template <typename T>
  bool operator()(const T* angles, const T* chain, const T* skew, const T* place, T* residuals) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Vector3 tilt_axis(chain[0], T(fixed_.tilt_axis_m.y()), T(fixed_.tilt_axis_m.z()));
    const Eigen::Map<const Vector3> camera(chain + 1), place_m(place + 3);
    const Vector3 back_pan(T(0), T(0), -angles[0]);
    const Vector3 back_tilt(T(0), angles[1] * ceres::cos(skew[0]), angles[1] * ceres::sin(skew[0]));
    const Vector3 back_camera = -Eigen::Map<const Vector3>(chain + 4);
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      T* const residual = residuals + 2 * dot;
      residual[0] = residual[1] = T(0);
      if (seen_.dots[dot].information.isZero(0)) continue;
      const Eigen::Vector2d on_sheet_m = landmark_.centre_m(dot);
      Vector3 at = (place_.rotation * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y())).cast<T>(), turned;
      const auto turn = [&](const T* rotation) {
        ceres::AngleAxisRotatePoint(rotation, at.data(), turned.data());
        at = turned;
      };
      turn(place);
      at += place_m;
      turn(back_pan.data());
      at -= tilt_axis;
      turn(back_tilt.data());
      at -= camera;
      turn(back_camera.data());
      Vector3 p = fixed_.R_tilted_camera.transpose().cast<T>() * at;
      if (p.z() < kNearest_m) p.z() = T(kNearest_m);  // a long way off, whatever direction that is in
      const Eigen::Matrix<T, 2, 1> off(p.x() / p.z() - seen_.dots[dot].ray.x(),
                                       p.y() / p.z() - seen_.dots[dot].ray.y());
      Eigen::Map<Eigen::Matrix<T, 2, 1>>{residual} = root_[dot].cast<T>() * off;
    }
    return true;
  }

 private:
  const LandmarkSighting& seen_;
  const FootFromLandmark place_;
  const LandmarkGeometry& landmark_;
  const Fixed& fixed_;
  std::array<Eigen::Matrix2d, kDotCount> root_;
};

/// (row . unknowns - right side) / sigma.
class LinearCost final : public ceres::CostFunction {
 public:
  LinearCost(std::vector<Eigen::VectorXd> rows, double right_side, double sigma)
      : rows_(std::move(rows)), right_side_(right_side), sigma_(sigma) {
    set_num_residuals(1);
    for (const Eigen::VectorXd& row : rows_) mutable_parameter_block_sizes()->push_back(static_cast<int>(row.size()));
  }
  bool Evaluate(const double* const* unknowns, double* residual, double** jacobians) const override {
    *residual = -right_side_ / sigma_;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      *residual += rows_[i].dot(Eigen::Map<const Eigen::VectorXd>(unknowns[i], rows_[i].size())) / sigma_;
      if (jacobians != nullptr && jacobians[i] != nullptr)
        Eigen::Map<Eigen::VectorXd>(jacobians[i], rows_[i].size()) = rows_[i] / sigma_;
    }
    return true;
  }

 private:
  std::vector<Eigen::VectorXd> rows_;
  double right_side_, sigma_;
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

Eigen::VectorXd table_unknowns(const AngleTable& table) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(table.angle_rad.size()) + 1);
  for (std::size_t i = 0; i < table.angle_rad.size(); ++i) values(static_cast<Eigen::Index>(i)) = table.angle_rad[i];
  values(values.size() - 1) = table.lag_rad;
  return values;
}

void take(const Eigen::VectorXd& values, AngleTable& table) {
  for (std::size_t i = 0; i < table.angle_rad.size(); ++i) table.angle_rad[i] = values(static_cast<Eigen::Index>(i));
  table.lag_rad = values(values.size() - 1);
}

/// Of the table's unknowns, what a stop's true angle is: the values, and the lag away from where it came from.
Eigen::VectorXd table_row(const AngleTable& table, double told_rad, int side) {
  Eigen::VectorXd row(static_cast<Eigen::Index>(table.told_rad.size()) + 1);
  row << knot_weights(table.told_rad, told_rad), -side;
  return row;
}

/// The lag is seen where an axis came from both sides.
constexpr int kLeastOfASide = 3;

/// The equations of all that counts. \pre the network outlives it, and does not change
class Equations {
 public:
  Equations(HeadNetwork& network, const HeadAdjustmentOptions& options)
      : network_(network),
        options_(options),
        fixed_{camera_on_body({.camera_rpy_rad = network.body.camera_rpy_rad}, {}).T_body_camera.rotation,
               network.body.tilt_axis_m},
        skew_rad_(network.skew_rad),
        pan_(table_unknowns(network.pan)),
        tilt_(table_unknowns(network.tilt)) {
    chain_ << network.body.tilt_axis_m.x(), network.body.camera_m, Eigen::Vector3d::Zero();
    for (const LandmarkPlace& place : network.places) {
      places_.emplace_back();
      places_.back() << Eigen::Vector3d::Zero(), place.T_foot_landmark.translation_m;
    }
    for (const HeadAngles& at : network.angles) angles_.emplace_back(at.pan_rad, at.tilt_rad);
    ordering_ = std::make_shared<ceres::ParameterBlockOrdering>();
    add_sightings();
    add_axis(network.pan, pan_, 0);
    add_axis(network.tilt, tilt_, 1);
    for (Eigen::Vector2d& at : angles_)
      if (problem_.HasParameterBlock(at.data())) ordering_->AddElementToGroup(at.data(), 0);
    for (double* const block : globals()) ordering_->AddElementToGroup(block, 1);
    if (!options.frees_skew) {
      problem_.SetParameterBlockConstant(&skew_rad_);
      ordering_->AddElementToGroup(&skew_rad_, 1);
    }
  }

  bool solve() {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.linear_solver_ordering = ordering_;
    solver.num_threads = 1;  // sums in one order: the same pictures give the same head
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = kSettled;
    solver.parameter_tolerance = 0;
    solver.logging_type = ceres::SILENT;
    Reporter reporter(options_.go_on);
    if (options_.go_on) solver.callbacks.push_back(&reporter);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    if (!summary.IsSolutionUsable() || !chain_.allFinite()) return false;
    hand_back();
    return true;
  }

  /// Inverse of J^T J over globals(), then the counting stops' angles.
  HeadCovariance covariance() {
    std::vector<double*> blocks = globals();
    std::vector<std::size_t> stops;
    for (std::size_t i = 0; i < angles_.size(); ++i)
      if (problem_.HasParameterBlock(angles_[i].data())) stops.push_back(i), blocks.push_back(angles_[i].data());
    const Eigen::MatrixXd C = inverse_normal(blocks);
    const Eigen::Index pan_at = kChainUnknowns + (options_.frees_skew ? 1 : 0), tilt_at = pan_at + pan_.size();
    HeadCovariance result;
    result.chain = C.topLeftCorner<kChainUnknowns, kChainUnknowns>();
    if (options_.frees_skew) result.skew_rad2 = C(kChainUnknowns, kChainUnknowns);
    result.pan = C.block(pan_at, pan_at, pan_.size(), pan_.size());
    result.tilt = C.block(tilt_at, tilt_at, tilt_.size(), tilt_.size());
    result.pan_tie_rad2.assign(angles_.size(), 0);
    result.tilt_tie_rad2.assign(angles_.size(), 0);
    Eigen::Index at = C.rows() - 2 * static_cast<Eigen::Index>(stops.size());
    for (const std::size_t stop : stops) {
      const HeadStop& seen = network_.stops[stop];
      const auto variance = [&](Eigen::Index angle, Eigen::Index table, const Eigen::VectorXd& row) {
        return C(angle, angle) - 2 * row.dot(C.block(table, angle, row.size(), 1).col(0)) +
               row.dot(C.block(table, table, row.size(), row.size()) * row);
      };
      result.pan_tie_rad2[stop] = variance(at, pan_at, table_row(network_.pan, seen.told.pan_rad, seen.pan_side));
      result.tilt_tie_rad2[stop] =
          variance(at + 1, tilt_at, table_row(network_.tilt, seen.told.tilt_rad, seen.tilt_side));
      at += 2;
    }
    return result;
  }

 private:
  std::vector<double*> globals() {
    std::vector<double*> blocks{chain_.data()};
    if (options_.frees_skew) blocks.push_back(&skew_rad_);
    blocks.push_back(pan_.data()), blocks.push_back(tilt_.data());
    for (auto& place : places_)
      if (problem_.HasParameterBlock(place.data())) blocks.push_back(place.data());
    return blocks;
  }

  void add_sightings() {
    using Cost = ceres::AutoDiffCostFunction<SightingCost, kDotResiduals, 2, kChainUnknowns, 1, kPlaceUnknowns>;
    for (const StopSighting& sighting : network_.sightings) {
      if (!network_.counts(sighting)) continue;
      ceres::LossFunction* const loss =
          options_.is_robust ? new ceres::CauchyLoss(std::sqrt(chi2_limit(residual_count(*sighting.seen)))) : nullptr;
      problem_.AddResidualBlock(new Cost(new SightingCost(sighting, network_, fixed_)), loss,
                                angles_[sighting.stop].data(), chain_.data(), &skew_rad_,
                                places_[sighting.place].data());
    }
  }

  /// What an axis told, its anchor, and what is believed of its lag. \param axis  0: pan, 1: tilt
  void add_axis(const AngleTable& table, Eigen::VectorXd& unknowns, int axis) {
    const double spread_rad = axis == 0 ? network_.pan_spread_rad : network_.tilt_spread_rad;
    int rising = 0, falling = 0;
    for (std::size_t i = 0; i < angles_.size(); ++i) {
      if (!problem_.HasParameterBlock(angles_[i].data())) continue;
      const HeadStop& stop = network_.stops[i];
      const int side = axis == 0 ? stop.pan_side : stop.tilt_side;
      rising += side > 0, falling += side < 0;
      const Eigen::VectorXd row = table_row(table, axis == 0 ? stop.told.pan_rad : stop.told.tilt_rad, side);
      ceres::LossFunction* const loss = options_.is_robust ? new ceres::CauchyLoss(kTieLoss) : nullptr;
      problem_.AddResidualBlock(new LinearCost({Eigen::Vector2d::Unit(axis), -row}, 0, spread_rad), loss,
                                angles_[i].data(), unknowns.data());
    }
    const double anchor = anchor_rad(table.told_rad);
    problem_.AddResidualBlock(new LinearCost({table_row(table, anchor, 0)}, anchor, kAnchored_rad), nullptr,
                              unknowns.data());
    const bool sees_lag = rising >= kLeastOfASide && falling >= kLeastOfASide;
    problem_.AddResidualBlock(new LinearCost({Eigen::VectorXd::Unit(unknowns.size(), unknowns.size() - 1)}, 0,
                                             sees_lag ? kMostLag_rad : kNoLag_rad),
                              nullptr, unknowns.data());
  }

  Eigen::MatrixXd inverse_normal(const std::vector<double*>& blocks) {
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.parameter_blocks = blocks;
    evaluate.apply_loss_function = false;
    ceres::CRSMatrix J;
    problem_.Evaluate(evaluate, nullptr, nullptr, nullptr, &J);
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(J.num_cols, J.num_cols);
    for (std::size_t row = 0; row + 1 < J.rows.size(); ++row)
      for (int a = J.rows[row]; a < J.rows[row + 1]; ++a)
        for (int b = J.rows[row]; b < J.rows[row + 1]; ++b) {
          const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
          N(J.cols[i], J.cols[j]) += J.values[i] * J.values[j];
        }
    // Metres and radians differ by their nature: scaled, so that the inverse keeps its digits.
    const Eigen::VectorXd scale = N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * N * scale.asDiagonal();
    const Eigen::MatrixXd inverse = scaled.ldlt().solve(Eigen::MatrixXd::Identity(N.rows(), N.cols()));
    return scale.asDiagonal() * inverse * scale.asDiagonal();
  }

  void hand_back() {
    network_.body.tilt_axis_m.x() = chain_(0);
    network_.body.camera_m = chain_.segment<3>(1);
    const Eigen::Matrix3d optical = camera_on_body({}, {}).T_body_camera.rotation;
    const YawPitchRoll askew = yaw_pitch_roll(exp_so3(chain_.tail<3>()) * fixed_.R_tilted_camera * optical.transpose());
    network_.body.camera_rpy_rad = {askew.roll_rad, askew.pitch_rad, askew.yaw_rad};
    network_.skew_rad = skew_rad_;
    take(pan_, network_.pan);
    take(tilt_, network_.tilt);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      FootFromLandmark& T = network_.places[i].T_foot_landmark;
      T = {exp_so3(places_[i].head<3>()) * T.rotation, places_[i].tail<3>()};
    }
    for (std::size_t i = 0; i < angles_.size(); ++i) network_.angles[i] = {angles_[i].x(), angles_[i].y()};
  }

  HeadNetwork& network_;
  const HeadAdjustmentOptions& options_;
  const Fixed fixed_;
  Eigen::Matrix<double, kChainUnknowns, 1> chain_;
  double skew_rad_;
  Eigen::VectorXd pan_, tilt_;
  std::vector<Eigen::Matrix<double, kPlaceUnknowns, 1>> places_;
  std::vector<Eigen::Vector2d> angles_;
  ceres::Problem problem_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_;
};

}  // namespace

bool adjust_head(HeadNetwork& network, const HeadAdjustmentOptions& options) {
  if (std::ranges::none_of(network.sightings, [&](const StopSighting& sighting) { return network.counts(sighting); }))
    return false;
  return Equations(network, options).solve();
}

HeadCovariance covariance_of_head(HeadNetwork& network, bool frees_skew) {
  const HeadAdjustmentOptions options{.is_robust = false, .frees_skew = frees_skew, .max_iterations = 0, .go_on = {}};
  return Equations(network, options).covariance();
}

HeadAngles tie_of(const HeadNetwork& network, std::size_t stop) {
  const HeadStop& seen = network.stops[stop];
  const HeadAngles foretold = angles_of(network, seen.told);
  return {network.angles[stop].pan_rad - foretold.pan_rad + seen.pan_side * network.pan.lag_rad,
          network.angles[stop].tilt_rad - foretold.tilt_rad + seen.tilt_side * network.tilt.lag_rad};
}

double chi2_of(const HeadNetwork& network, const StopSighting& sighting) {
  const BodyFromCamera T = camera_on_body(network.body, network.angles[sighting.stop]).T_body_camera;
  const FootFromLandmark& place = network.places[sighting.place].T_foot_landmark;
  // The foot takes the world's place.
  return fit_of_sighting(*sighting.seen, {place.rotation, place.translation_m}, {T.rotation, T.translation_m},
                         network.landmark)
      .chi2;
}

int residual_count(const LandmarkSighting& sighting) {
  return 2 * static_cast<int>(std::ranges::count_if(sighting.dots,
                                                    [](const DotSighting& dot) { return !dot.information.isZero(0); }));
}

}  // namespace ninedot
