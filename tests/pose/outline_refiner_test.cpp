#include "pose/outline_refiner.h"

#include <gtest/gtest.h>

#include "pose/mirror_image.h"
#include "tests/pose/first_fit.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

/// A picture of the landmark, what a solver makes of it, and a refiner for more.
struct Fitted {
  explicit Fitted(const test::Viewpoint& viewpoint) {
    test::Scene scene;
    scene.camera = test::look_at_landmark(viewpoint);
    picture = test::render(scene, 1);
    fit = test::first_fit(picture.view());
  }
  OptimiserStatistics refine(const OutlineState& start, double hopeless_lsb = 1e9) {
    int pixels = 100'000;
    return refiner.refine(picture.view(), start, OutlineRefiner::Start::kClose, 0, pixels,
                          OutlineRefiner::Light::kSimple, hopeless_lsb);
  }
  OutlineState mirrored() const {
    OutlineState state = refiner.state();
    state.T_camera_landmark = mirror_image(state.T_camera_landmark, landmark);
    return state;
  }
  const CameraModel camera;
  const LandmarkGeometry landmark;
  const RayTable rays{camera};
  test::Picture picture;
  OutlineRefiner refiner{camera, landmark, rays};
  decltype(test::first_fit(ImageView{})) fit;
};

/// Whoever asks whether it is more than so much is told so, and need not wait for how much it is.
TEST(OutlineRefiner, SaysThatAnotherPoseIsWorseBeforeItKnowsByHowMuch) {
  Fitted seen({.distance_m = 1.2, .tilt_rad = 0.4, .azimuth_rad = 0.7});
  ASSERT_TRUE(seen.fit);
  ASSERT_TRUE(seen.refine(seen.fit->outlines).has_converged());
  const OutlineRefiner& refiner = seen.refiner;
  const OutlineState mirrored = seen.mirrored();
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
  Fitted seen({.distance_m = 1.0, .tilt_rad = 0.5, .azimuth_rad = 0.7});
  ASSERT_TRUE(seen.fit);
  ASSERT_TRUE(seen.refine(seen.fit->outlines).has_converged());
  const double residual_lsb = seen.refiner.fit().residual_lsb;
  const OutlineState mirrored = seen.mirrored();
  EXPECT_TRUE(seen.refine(seen.fit->outlines, 3 * residual_lsb).has_converged());
  ASSERT_GT(seen.refine(mirrored).iterations, 3);
  ASSERT_GT(seen.refiner.fit().residual_lsb, 3 * residual_lsb) << "or this picture tests nothing";
  const OptimiserStatistics steps = seen.refine(mirrored, 3 * residual_lsb);
  EXPECT_EQ(steps.stopped, Stopped::kLedNowhere);
  EXPECT_EQ(steps.iterations, 3);
}

}  // namespace
}  // namespace ninedot
