#include "pose/outline_sums.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/renderer.h"

namespace ninedot {
namespace {

double squares(const OutlinePixels& pixels, const OutlineState& state) {
  double sum = 0;
  const LandmarkGeometry landmark;
  GroupFitter fitter(pixels, landmark, state, Asked::kLightOnly);
  GroupFit fit;
  for (const OutlineGroup& group : pixels.groups) {
    fitter.fit(group, fit);
    sum += fit.squared_residuals;
  }
  return sum;
}

TEST(OutlineSums, GradientEqualsCentralDifferencesOfTheSquaredResiduals) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.0, .tilt_rad = 0.5, .azimuth_rad = 0.7});
  set_noise(scene.sensor, 1.0);
  const test::Picture picture = test::render(scene, 1);
  const auto& q = scene.camera.quaternion_wxyz;
  const auto& p = scene.camera.position_m;
  Transform<frame::Landmark, frame::Camera> truth;
  truth.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  truth.translation_m = {p[0], p[1], p[2]};

  OutlineState state;
  state.T_camera_landmark = truth.inverse();
  state.blur_px2 = 0.4;
  UnknownVector off = UnknownVector::Zero();
  off << 2e-4, -1e-4, 2e-4, 1e-4, -2e-4, 1e-3, 0, 0, 0, 0;  // a fraction of a pixel
  state.apply(off);

  const CameraModel camera;
  const RayTable rays(camera);
  OutlinePixels pixels(12000);
  collect_outline_pixels(picture.view(), camera, rays, LandmarkGeometry{}, state.T_camera_landmark, 3, 1, {}, {},
                         pixels);
  ASSERT_GE(pixels.groups.size(), kDotCount);

  UnknownVector gradient = UnknownVector::Zero();
  UnknownMatrix normal = UnknownMatrix::Zero();
  const LandmarkGeometry landmark;
  GroupFitter fitter(pixels, landmark, state, Asked::kState);
  GroupFit fit;
  for (const OutlineGroup& group : pixels.groups) {
    fitter.fit(group, fit);
    ASSERT_TRUE(fit.usable);
    gradient += fit.gradient;
    normal += fit.normal;
  }
  // From the sheet's axes to the camera's, which a step is along.
  UnknownMatrix turn = UnknownMatrix::Identity();
  turn.block<3, 3>(0, 0) = turn.block<3, 3>(3, 3) = state.T_camera_landmark.rotation;
  gradient = (turn * gradient).eval();
  normal = (turn * normal * turn.transpose()).eval();
  // Steps that move outlines by about a hundredth of a pixel.
  const std::array<double, kUnknowns> steps{1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-4, 0.01, 0.01, 0.01, 0.01};
  for (int k = 0; k < kUnknowns; ++k) {
    UnknownVector step = UnknownVector::Zero();
    step(k) = steps[static_cast<std::size_t>(k)];
    OutlineState ahead = state, behind = state;
    ahead.apply(step);
    behind.apply(-step);
    const double numeric = -(squares(pixels, ahead) - squares(pixels, behind)) / (4 * step(k));
    // The Jacobian leaves out how the outline's steepness changes with the pose: second order in the distance.
    const double scale = std::sqrt(normal(k, k) * squares(pixels, state));
    EXPECT_NEAR(gradient(k), numeric, 0.03 * scale) << "unknown " << k;
  }
}

TEST(OutlineState, BlurStaysPossible) {
  OutlineState state;
  UnknownVector step = UnknownVector::Zero();
  step(7) = -10, step(8) = 5, step(9) = -5;
  state.apply(step);
  EXPECT_GT(state.blur_px2, 0);
  EXPECT_LT(std::hypot(state.blur_cos_px2, state.blur_sin_px2), state.blur_px2);
}

}  // namespace
}  // namespace ninedot
