#include "pose/tone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

#include "pose/outline_refiner.h"
#include "tests/pose/first_fit.h"

namespace ninedot {
namespace {

/// What grey levels say of a share of ink. 0..1
double seen_share(double share, double paper_light, double ink_light) {
  const auto grey_of = [](double light) { return test::grey_from_light(light, test::ToneCurve::kSrgb); };
  return (grey_of(paper_light) - grey_of(paper_light + share * (ink_light - paper_light))) /
         (grey_of(paper_light) - grey_of(ink_light));
}

TEST(Tone, BendsSharesOfInkAsAnSrgbCurveDoes) {
  for (const double paper_light : {0.08, 0.3, 0.8})
    for (const double ink_of_paper : {0.04, 0.15, 0.5}) {
      const double ink_light = ink_of_paper * paper_light;
      const double paper_lsb = test::grey_from_light(paper_light, test::ToneCurve::kSrgb),
                   ink_lsb = test::grey_from_light(ink_light, test::ToneCurve::kSrgb);
      const auto [a, b, c] = srgb_bend(paper_lsb, paper_lsb - ink_lsb);
      for (double s = 0; s <= 1; s += 0.05) {
        const double bent =
            s + s * (1 - s) * (static_cast<double>(a) + s * (static_cast<double>(b) + s * static_cast<double>(c)));
        EXPECT_NEAR(bent, seen_share(s, paper_light, ink_light), 0.02)
            << paper_light << ' ' << ink_of_paper << ' ' << s;
      }
    }
}

TEST(Tone, OfLightThatIsAllOneIsNone) {
  const ToneBend none{};
  EXPECT_EQ(srgb_bend(120, 0), none);
}

TEST(Tone, StraightenedIsLight) {
  for (const double paper_light : {0.12, 0.4, 0.9}) {
    const auto grey_of = [&](double share_of_paper) {
      return std::round(test::grey_from_light(share_of_paper * paper_light, test::ToneCurve::kSrgb));
    };
    // Mostly paper, as about a landmark; a little is brighter, and the rest is mixed with ink, or wall.
    std::vector<float> luma(60, static_cast<float>(grey_of(1)));
    for (const double share : {1.05, 0.8, 0.6, 0.4, 0.2})
      for (int i = 0; i < 4; ++i) luma.push_back(static_cast<float>(grey_of(share)));
    const std::vector<float> before = luma;
    straighten_tone(luma);
    EXPECT_EQ(luma[0], before[0]) << "the paper is as bright as it was";
    const auto light = [&](std::size_t mixture) { return static_cast<double>(luma[60 + 4 * mixture]); };
    EXPECT_NEAR((light(1) - light(2)) / (light(1) - light(4)), 1 / 3.0, 0.02) << paper_light;
    EXPECT_NEAR((light(2) - light(3)) / (light(1) - light(4)), 1 / 3.0, 0.02) << paper_light;
    EXPECT_NEAR((luma[60] - before[60]) / (before[60] - before[0]), 0, 0.05) << "noise of paper is as large as it was";
  }
}

// Taken for an offset of all outlines, the curve displaced the blurred dots against P9 so far that the pose was 15 mm
// uncertain (1-sigma), and off by 2.6 mm.
TEST(Tone, OfAPictureThatIsOutOfFocusIsKnown) {
  constexpr int kViews = 12;
  double squares_m2 = 0, sigmas_m = 0;
  for (std::uint64_t seed = 1; seed <= kViews; ++seed) {
    test::Scene scene = test::scene_of(test::nine_dot_sheet(), {.distance_m = 2.6, .tilt_rad = 0.9});
    scene.sensor.point_spread_px = 1.2;
    scene.wall.seed = seed;
    const auto best = test::first_fit(test::render(scene, seed).view());
    ASSERT_TRUE(best) << seed;
    const Eigen::Vector3d off_m =
        best->pose.T_landmark_camera.translation_m - Eigen::Vector3d::Map(scene.camera.position_m.data());
    squares_m2 += off_m.squaredNorm() / kViews;
    sigmas_m += std::sqrt(best->pose.covariance.topLeftCorner<3, 3>().trace()) / kViews;
  }
  EXPECT_LT(std::sqrt(squares_m2), 1.6e-3);
  EXPECT_LT(sigmas_m, 3e-3);
  EXPECT_GT(sigmas_m, 0.8 * std::sqrt(squares_m2));
}

// Along a track as in a search, or the landmark would be lost wherever a lens is out of focus.
TEST(Tone, OfAPictureThatIsOutOfFocusIsKnownAlongATrack) {
  test::Scene scene = test::scene_of(test::nine_dot_sheet(), {.distance_m = 2.6, .tilt_rad = 0.9});
  scene.sensor.point_spread_px = 1.2;
  const auto first = test::first_fit(test::render(scene, 1).view());
  ASSERT_TRUE(first);
  const double first_sigma_m = std::sqrt(first->pose.covariance.topLeftCorner<3, 3>().trace());
  FullSolver solver(CameraModel{}, LandmarkGeometry{});
  const PosePrior prior{first->pose.T_landmark_camera.inverse(), first->outlines, 0, true};
  for (std::uint64_t seed = 2; seed < 8; ++seed) {
    const test::Picture next = test::render(scene, seed);
    int pixels = 100'000;
    const auto followed = solver.follow(next.view(), {prior.T_camera_landmark, first->pose}, prior, pixels);
    ASSERT_TRUE(followed) << seed;
    const PoseEstimate& pose = followed->list[0].pose;
    EXPECT_LT(std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace()), 1.3 * first_sigma_m) << seed;
  }
}

/// The outlines of a picture as the refiner sees them from what they were taken for first.
OutlineState fitted(const test::Scene& scene, OutlineRefiner::Light light) {
  const CameraModel camera;
  const LandmarkGeometry landmark;
  const RayTable rays(camera);
  const test::Picture picture = test::render(scene, 1);
  const auto first = test::first_fit(picture.view());
  OutlineRefiner refiner(camera, landmark, rays);
  int pixels = 100'000;
  EXPECT_TRUE(
      first &&
      refiner.refine(picture.view(), first->outlines, OutlineRefiner::Start::kClose, 0, pixels, light).has_converged());
  return refiner.state();
}

TEST(Tone, IsWhatTheCamerasCurveIs) {
  test::Scene scene = test::scene_of(test::nine_dot_sheet(), {.distance_m = 2.6, .tilt_rad = 0.9});
  scene.sensor.point_spread_px = 1.2;
  EXPECT_NEAR(fitted(scene, OutlineRefiner::Light::kFull).tone, 0.9, 0.2);  // its prior is a half
  scene.sensor.tone = test::ToneCurve::kLinear;
  EXPECT_NEAR(fitted(scene, OutlineRefiner::Light::kFull).tone, 0, 0.2);
}

// Of larger dots the offset explains nearly as much: the curve is found from the side where it is one.
TEST(Tone, IsACurveAlsoOfLargerDots) {
  test::Scene scene = test::scene_of(test::nine_dot_sheet(), {.distance_m = 1.5, .tilt_rad = 0.5});
  scene.sensor.point_spread_px = 1.2;
  EXPECT_GT(fitted(scene, OutlineRefiner::Light::kFull).tone, 0.5);
}

// Of a sharp picture a curve is an offset, and nothing else is asked where readings are decided.
TEST(Tone, IsAnOffsetWhereNothingTellsThemApart) {
  test::Scene scene = test::scene_of(test::nine_dot_sheet(), {.distance_m = 1.5, .tilt_rad = 0.5});
  const OutlineState sharp = fitted(scene, OutlineRefiner::Light::kFull);
  EXPECT_EQ(sharp.tone, 0);
  EXPECT_LT(sharp.offset_px, -0.15);
  scene.sensor.point_spread_px = 1.2;
  const OutlineState blurred = fitted(scene, OutlineRefiner::Light::kSimple);
  EXPECT_EQ(blurred.tone, 0);
  EXPECT_LT(blurred.offset_px, -0.15);
}

// Squares for dots: a curve that suits them makes the rest fit worse.
TEST(Tone, IsNotTakenWhereTheGreyLevelsFitWorseWithIt) {
  const CameraModel camera;
  const LandmarkGeometry landmark;
  const RayTable rays(camera);
  for (const auto& [blur_px, distance_m, tilt_rad] :
       {std::tuple(1.0, 1.8, 0.1), std::tuple(1.2, 1.8, 0.4), std::tuple(0.9, 3.4, 0.1), std::tuple(0.8, 2.6, 0.4)}) {
    test::Scene scene =
        test::scene_of(test::square_dot_sheet(), {.distance_m = distance_m, .tilt_rad = tilt_rad, .azimuth_rad = 0.7});
    scene.sensor.point_spread_px = blur_px;
    const test::Picture picture = test::render(scene, 1);
    const auto best = test::first_fit(picture.view());
    ASSERT_TRUE(best);
    OutlineRefiner simple(camera, landmark, rays);
    int pixels = 100'000;
    ASSERT_TRUE(
        simple.refine(picture.view(), best->outlines, OutlineRefiner::Start::kClose, 0, pixels).has_converged());
    EXPECT_LT(best->fit.residual_lsb, 1.03 * simple.fit().residual_lsb) << distance_m << " m";
  }
}

}  // namespace
}  // namespace ninedot
