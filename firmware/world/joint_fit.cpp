#include "world/joint_fit.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "base/contract.h"
#include "geometry/levenberg_marquardt.h"

namespace ninedot {
namespace {

/// A step that changes chi^2 by no more is the last: a third of a sigma, and what is left after it is its square in
/// units of how far the likelihood is from normal.
constexpr double kNegligible_chi2 = 0.1;

/// Random rooms need 2 to 5 from the pose of one sighting (tests/world/world_accuracy_test.cpp).
constexpr LevenbergMarquardtOptions kLoop{.max_iterations = 15, .least_failed_damping = 1e-3};

/// The problem for levenberg_marquardt: what it asks of a place twice, cost and derivatives, is summed up once.
class JointProblem {
 public:
  using State = WorldFromCamera;
  static constexpr int kUnknowns = 6;

  JointProblem(std::span<const JointMember> members, const LandmarkGeometry& landmark, JointFit& fit) noexcept
      : members_(members), landmark_(landmark), fit_(fit) {}

  double linearise(const State& state, PoseInformation& normal, PoseStep& gradient) const noexcept {
    if (!is_at(state)) sum_up(state);
    normal = normal_ = fit_.sum.normal;
    gradient = fit_.sum.gradient;
    return fit_.sum.chi2;
  }
  double cost(const State& state) const noexcept {
    if (!is_at(state)) sum_up(state);
    return fit_.sum.chi2;
  }
  State moved(const State& state, const PoseStep& step) const noexcept { return moved_by(state, step); }
  bool is_negligible(const State&, const PoseStep& step) const noexcept {
    return step.dot(normal_ * step) < kNegligible_chi2;
  }
  void sum_up(const State& state) const noexcept {
    fit_.T_world_camera = state;
    fit_.sum = {};
    for (std::size_t i = 0; i < members_.size(); ++i) {
      fit_.of_each[i] = fit_of_member(members_[i], state, landmark_);
      fit_.sum += fit_.of_each[i];
    }
    summed_up_ = true;
  }
  bool is_at(const State& state) const noexcept {
    return summed_up_ && state.translation_m == fit_.T_world_camera.translation_m &&
           state.rotation == fit_.T_world_camera.rotation;
  }

 private:
  std::span<const JointMember> members_;
  const LandmarkGeometry& landmark_;
  JointFit& fit_;
  mutable bool summed_up_ = false;  // fit_ is that of its place
  mutable PoseInformation normal_;  // of the place that the step leads away from
};

}  // namespace

SightingFit fit_of_member(const JointMember& member, const WorldFromCamera& T_world_camera,
                          const LandmarkGeometry& landmark) noexcept {
  const SightingFit fit = fit_of_sighting(*member.sighting, member.T_world_landmark, T_world_camera, landmark);
  if (member.place_covariance == nullptr) return fit;
  return softened(fit, step_covariance_of_place(*member.place_covariance, member.T_world_landmark, T_world_camera));
}

void fit_jointly(std::span<const JointMember> members, const WorldFromCamera& start, const LandmarkGeometry& landmark,
                 JointFit& fit) noexcept {
  EXPECTS(!members.empty() && members.size() <= kMaxSightings);
  const JointProblem problem(members, landmark, fit);
  WorldFromCamera state = start;
  fit.statistics = levenberg_marquardt(problem, state, kLoop);
  if (!problem.is_at(state)) problem.sum_up(state);
  const bool is_determined =
      std::isfinite(fit.sum.chi2) && fit.sum.normal.llt().info() == Eigen::Success && fit.sum.dots >= 3;
  if (!is_determined) fit.statistics.stopped = Stopped::kUndetermined;
}

}  // namespace ninedot
