#include "pose/outline_refiner.h"

#include <gtest/gtest.h>

#include "pose/mirror_image.h"
#include "tests/pose/first_fit.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

/// Whoever asks whether it is more than so much is told so, and need not wait for how much it is.
TEST(OutlineRefiner, SaysThatAnotherPoseIsWorseBeforeItKnowsByHowMuch) {
  const CameraModel camera;
  const LandmarkGeometry landmark;
  const RayTable rays(camera);
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.2, .tilt_rad = 0.4, .azimuth_rad = 0.7});
  const test::Picture picture = test::render(scene, 1);
  const auto fit = test::first_fit(picture.view());
  ASSERT_TRUE(fit);
  OutlineRefiner refiner(camera, landmark, rays);
  int pixels = 100'000;
  ASSERT_TRUE(refiner.refine(picture.view(), fit->outlines, OutlineRefiner::Start::kClose, 0, pixels).has_converged());
  OutlineState mirrored = refiner.state();
  mirrored.T_camera_landmark = mirror_image(mirrored.T_camera_landmark, landmark);
  const double all = refiner.chi2_above(mirrored);
  ASSERT_GT(all, 5000);
  for (const double enough : {10.0, 100.0, 1000.0}) {
    const double some = refiner.chi2_above(mirrored, enough);
    EXPECT_GT(some, enough);
    EXPECT_LT(some, 0.9 * all) << "all groups were looked at";
  }
  // What is said early is no more than it turns out to be.
  const double at_least = refiner.chi2_above(mirrored, 0.6 * all);
  EXPECT_GT(at_least, 0.6 * all);
  EXPECT_LE(at_least, all);
  EXPECT_EQ(refiner.chi2_above(mirrored, 2 * all), all);
}

TEST(OutlineRefiner, GivesUpAPoseThatStaysMuchFurtherFromThePicture) {
  const CameraModel camera;
  const LandmarkGeometry landmark;
  const RayTable rays(camera);
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.0, .tilt_rad = 0.5, .azimuth_rad = 0.7});
  const test::Picture picture = test::render(scene, 1);
  const auto fit = test::first_fit(picture.view());
  ASSERT_TRUE(fit);
  using Refiner = OutlineRefiner;
  Refiner refiner(camera, landmark, rays);
  const auto steps_of = [&](const OutlineState& start, double hopeless_lsb) {
    int pixels = 100'000;
    return refiner.refine(picture.view(), start, Refiner::Start::kClose, 0, pixels, Refiner::Light::kSimple,
                          hopeless_lsb);
  };
  ASSERT_TRUE(steps_of(fit->outlines, 1e9).has_converged());
  const double residual_lsb = refiner.fit().residual_lsb;
  EXPECT_TRUE(steps_of(fit->outlines, 3 * residual_lsb).has_converged());
  OutlineState mirrored = refiner.state();
  mirrored.T_camera_landmark = mirror_image(mirrored.T_camera_landmark, landmark);
  ASSERT_GT(steps_of(mirrored, 1e9).iterations, 3);
  ASSERT_GT(refiner.fit().residual_lsb, 3 * residual_lsb) << "or this picture tests nothing";
  const OptimiserStatistics steps = steps_of(mirrored, 3 * residual_lsb);
  EXPECT_EQ(steps.stopped, Stopped::kLedNowhere);
  EXPECT_EQ(steps.iterations, 3);
}

}  // namespace
}  // namespace ninedot
