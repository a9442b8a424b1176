#include "calibrate_camera/view_fit.h"

#include <cmath>
#include <limits>
#include <vector>

#include "geometry/levenberg_marquardt.h"
#include "geometry/planar_pose.h"
#include "pose/outline_distance.h"

namespace ninedot {
namespace {

constexpr int kUnknownsOfView = kPoseUnknowns + 1;
/// Before any outline is seen nothing speaks for more: the widest offset that a tone curve made in rendered pictures
/// was 0.15 px. It keeps the offset where a view has one size of discs, far away.
constexpr double kOffset_px = 0.5;

/// For levenberg_marquardt().
struct ViewProblem {
  using State = ViewState;
  static constexpr int kUnknowns = kUnknownsOfView;
  using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;

  const CameraModel& camera;
  std::span<const PlaneDisc> discs;
  const SheetView& view;
  double floor_px;

  template <typename Use>
  double sum(const State& at, Use&& use) const noexcept {
    constexpr double c2 = kLoss_sigmas * kLoss_sigmas;
    double loss = at.offset_px * at.offset_px / (kOffset_px * kOffset_px);
    for (const EdgePoint& edge : view.edges) {
      const Result<OutlineDistance> seen = outline_distance(camera, discs[edge.disc], at.T_camera_sheet, edge.at_px);
      if (!seen) return std::numeric_limits<double>::infinity();
      const double sigma_px = total_sigma_px(edge, floor_px);
      const double residual = (seen->distance_px - at.offset_px) / sigma_px;
      loss += c2 * std::log1p(residual * residual / c2);
      use(*seen, residual, sigma_px, 1 / (1 + residual * residual / c2));
    }
    return loss;
  }
  double linearise(const State& at, Normal& normal, Vector& gradient) const noexcept {
    normal.setZero(), gradient.setZero();
    normal(6, 6) = 1 / (kOffset_px * kOffset_px), gradient(6) = at.offset_px / (kOffset_px * kOffset_px);
    return sum(at, [&](const OutlineDistance& seen, double residual, double sigma_px, double weight) {
      Vector J;
      J << seen.by_pose.transpose(), -1;
      J /= sigma_px;
      normal += weight * J * J.transpose();
      gradient += weight * residual * J;
    });
  }
  double cost(const State& at) const noexcept {
    return sum(at, [](const OutlineDistance&, double, double, double) {});
  }
  static State moved(State at, const Vector& step) noexcept {
    at.T_camera_sheet.rotation = exp_so3(step.head<3>() / kLever_m) * at.T_camera_sheet.rotation;
    at.T_camera_sheet.translation_m += step.segment<3>(3);
    at.offset_px += step(6);
    return at;
  }
  static bool is_negligible(const State& at, const Vector& step) noexcept {
    // A ten thousandth of a pixel at f = 1000 px.
    return step.head<6>().lpNorm<Eigen::Infinity>() < 1e-7 * at.T_camera_sheet.translation_m.norm();
  }
};

}  // namespace

std::optional<ViewFit> fit_view(const CameraModel& camera, std::span<const PlaneDisc> discs, const SheetView& view,
                                double floor_px, const ViewState* start) {
  std::vector<ViewState> starts;
  if (start != nullptr) starts.push_back(*start);
  std::vector<PlanePoint> points;
  for (const SeenDisc& seen : view.seen)
    if (const Result<Eigen::Vector2d> ray = camera.normalised_from_pixel(seen.centre_px))
      points.push_back({discs[seen.disc].centre_m, *ray});
  if (const Result<PlanarPoses> poses = solve_planar_pose(points))
    for (const PlanarPose& pose : *poses) starts.push_back({pose.T_camera_landmark, 0});
  std::optional<ViewFit> best;
  const ViewProblem problem{camera, discs, view, floor_px};
  for (ViewState state : starts) {
    levenberg_marquardt(problem, state);
    const double loss = problem.cost(state) / 2;
    if (std::isfinite(loss) && (!best || loss < best->loss)) best = ViewFit{state, loss};
  }
  return best;
}

std::vector<double> edge_residuals_px(const CameraModel& camera, std::span<const PlaneDisc> discs,
                                      const SheetView& view, const ViewState& state) {
  std::vector<double> residuals_px;
  for (const EdgePoint& edge : view.edges) {
    const Result<OutlineDistance> seen = outline_distance(camera, discs[edge.disc], state.T_camera_sheet, edge.at_px);
    residuals_px.push_back(seen ? seen->distance_px - state.offset_px : std::numeric_limits<double>::quiet_NaN());
  }
  return residuals_px;
}

}  // namespace ninedot
