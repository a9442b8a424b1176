#include "tests/bench/accuracy_trials.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "detect/detector.h"
#include "pose/ellipse_solver.h"
#include "pose/full_solver.h"
#include "tests/bench/crlb.h"
#include "tests/support/best_pose.h"
#include "tests/support/random.h"
#include "tests/support/renderer_optics.h"

namespace ninedot::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kWrongNumbering_rad = 20 * kDegree;  // half of the ring's step, less what noise may add

// Sums of one solver's trials.
class Score {
 public:
  void add(const test::CameraPose& truth, const PoseBound& bound, const PoseEstimate& estimate) {
    ++outcome_.poses;
    const Eigen::Vector3d true_m(truth.position_m[0], truth.position_m[1], truth.position_m[2]);
    const Eigen::Matrix3d true_R = test::rotation_of(truth);
    const auto& T = estimate.T_landmark_camera;
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(T.rotation.transpose() * true_R));
    if (turn.angle() > kWrongNumbering_rad || on_wrong_side(true_m, true_R, T.rotation)) {
      ++outcome_.wrong;
      return;
    }
    Vector6d error;
    error << true_m - T.translation_m, turn.angle() * turn.axis();
    const double position_m = error.head<3>().norm();
    squares_ += position_m * position_m;
    ratios_ += std::pow(position_m / bound.position_m, 2);
    nees_ += error.dot(estimate.covariance.ldlt().solve(error));
  }

  SolverOutcome outcome() const {
    SolverOutcome result = outcome_;
    const double used = outcome_.poses - outcome_.wrong;
    if (used > 0) {
      result.rms_m = std::sqrt(squares_ / used), result.rms_ratio = std::sqrt(ratios_ / used);
      result.nees = nees_ / used;
    }
    return result;
  }

 private:
  // The other planar solution has the sheet's normal mirrored about the line of sight. Nearer to it than to the truth
  // is the wrong side; below 3 degrees of tilt there are no two sides to tell apart.
  static bool on_wrong_side(const Eigen::Vector3d& true_m, const Eigen::Matrix3d& true_R, const Eigen::Matrix3d& R) {
    const Eigen::Vector3d sight = true_R.transpose() * true_m.normalized();
    const Eigen::Vector3d normal = true_R.row(1).transpose(), found = R.row(1).transpose();
    const Eigen::Vector3d mirrored = 2 * normal.dot(sight) * sight - normal;
    return normal.dot(sight) < std::cos(3 * kDegree) && found.dot(mirrored) > found.dot(normal);
  }

  SolverOutcome outcome_;
  double squares_ = 0, ratios_ = 0, nees_ = 0;
};

}  // namespace

CameraModel camera_of(const test::Lens& lens) {
  CameraModel camera;
  camera.width_px = lens.width_px, camera.height_px = lens.height_px;
  camera.fx_px = lens.fx_px, camera.fy_px = lens.fy_px, camera.cx_px = lens.cx_px, camera.cy_px = lens.cy_px;
  camera.k = lens.k;
  return camera;
}

test::Scene scene_of(const Condition& condition, std::uint64_t seed) {
  test::Random random(seed);
  test::Scene scene;
  test::Viewpoint view;
  view.distance_m = condition.distance_m, view.tilt_rad = condition.tilt_rad;
  view.azimuth_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  view.roll_rad = random.uniform(-15 * kDegree, 15 * kDegree);
  const double side = random.uniform(-1, 1) < 0 ? -1 : 1;
  view.off_axis_x_rad = side * condition.off_axis_rad + random.uniform(-kDegree, kDegree);
  view.off_axis_y_rad = random.uniform(-kDegree, kDegree);
  scene.camera = test::look_at_landmark(view);
  if (condition.distorted) scene.lens.k = {-0.12, 0.05, 0.0008, -0.0005};
  scene.wall.seed = random.bits();
  scene.wall.reflectance = random.uniform(0.15, 0.5);
  scene.board.hidden_fraction = condition.hidden_fraction;
  scene.board.direction_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  scene.board.texture.seed = random.bits();
  const double light_from_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  scene.light.gradient_x_per_m = condition.light_gradient_per_m * std::cos(light_from_rad);
  scene.light.gradient_z_per_m = condition.light_gradient_per_m * std::sin(light_from_rad);
  if (condition.light_gradient_per_m > 0) scene.light.level = 0.6;
  if (condition.hard_shadow) scene.light.shadows = {{light_from_rad, random.uniform(-0.06, 0.06), 0.07, 0.003, 0.3}};
  scene.haze.veil = condition.veil;
  scene.sensor.tone = condition.tone;
  test::set_noise(scene.sensor, condition.noise_at_grey128_lsb);
  return scene;
}

Outcome run_trials(const Condition& condition, int trials, std::uint64_t seed) {
  const CameraModel camera = camera_of(scene_of(condition, 0).lens);
  const LandmarkGeometry landmark;
  Detector detector(camera, landmark);
  FullSolver full(camera, landmark);
  const EllipseSolver ellipse(camera, landmark, EllipseCalibration{});
  Outcome outcome;
  Score full_score, ellipse_score;
  for (int trial = 0; trial < trials; ++trial) {
    const std::uint64_t trial_seed = test::random_bits(seed, static_cast<std::uint64_t>(trial));
    const test::Scene scene = scene_of(condition, trial_seed);
    const auto bound = cramer_rao_bound(scene);
    if (!bound) continue;  // too little is visible for any pose
    ++outcome.trials;
    outcome.bound_m += bound->position_m * bound->position_m;
    const test::Picture picture = test::render(scene, trial_seed);
    const auto seen = detector.find_landmarks(picture.view());
    if (!seen) continue;
    ++outcome.found;
    int pixels = WorkBudget{}.pixels;
    if (const auto pose = test::best_pose(full.solve(picture.view(), seen->front(), nullptr, pixels)))
      full_score.add(scene.camera, *bound, *pose);
    if (const auto pose = test::best_pose(ellipse.solve(seen->front()))) ellipse_score.add(scene.camera, *bound, *pose);
  }
  if (outcome.trials > 0) outcome.bound_m = std::sqrt(outcome.bound_m / outcome.trials);
  outcome.full = full_score.outcome(), outcome.ellipse = ellipse_score.outcome();
  return outcome;
}

}  // namespace ninedot::bench
