// The simulated camera's pictures against those of the tests' own renderer, which casts all rays and shares nothing
// with it, and against the estimator: what it sees in them must agree with the truth within what it claims.
#include "drivers/simulation/sheet_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/units.h"
#include "pipeline/localiser.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"
#include "tests/support/renderer.h"
#include "tests/support/renderer_optics.h"

namespace ninedot {
namespace {

using Eigen::Isometry3d;

CameraModel camera_of(const test::Lens& lens) {
  CameraModel camera;
  camera.width_px = lens.width_px, camera.height_px = lens.height_px;
  camera.fx_px = lens.fx_px, camera.fy_px = lens.fy_px, camera.cx_px = lens.cx_px, camera.cy_px = lens.cy_px;
  camera.model = lens.model == test::LensModel::kPlumbBob   ? DistortionModel::kPlumbBob
                 : lens.model == test::LensModel::kRational ? DistortionModel::kRationalPolynomial
                                                            : DistortionModel::kEquidistant;
  camera.k = lens.k;
  return camera;
}

HungSheet black_sheet() {
  HungSheet sheet;
  sheet.inks.fill({0.04F, 0.04F, 0.04F});
  return sheet;
}

/// Of a camera that stands still; the sheet's frame is the world.
ExposureMotion at_rest(const test::CameraPose& pose) {
  const auto& [w, x, y, z] = pose.quaternion_wxyz;
  Isometry3d T(Eigen::Quaterniond(w, x, y, z).toRotationMatrix());
  T.translation() = Eigen::Vector3d(pose.position_m.data());
  return {{T, T, T}, {}};
}

test::Scene scene_of(const test::Lens& lens, const test::Viewpoint& view) {
  test::Scene scene;
  scene.lens = lens;
  scene.camera = test::look_at_landmark(view);
  scene.wall = {.reflectance = 0.30 / 0.85, .contrast = 0};
  scene.sensor.point_spread_px = 0.6;
  return scene;
}

RendererOptions without_noise() { return {.blur_px = 0.6, .noise_lsb = 0}; }

struct Difference {
  double largest_lsb = 0, rms_lsb = 0;
};

Difference difference(const ImageView& a, const ImageView& b) {
  Difference result;
  double sum = 0;
  for (int v = 0; v < a.height_px; ++v)
    for (int u = 0; u < a.width_px; ++u) {
      const double off = std::abs(a.at(u, v) - b.at(u, v));
      result.largest_lsb = std::max(result.largest_lsb, off);
      sum += off * off;
    }
  result.rms_lsb = std::sqrt(sum / (a.width_px * a.height_px));
  return result;
}

/// Centroid of what is darker than paper around a place.
Eigen::Vector2d dark_centroid(const ImageView& picture, const Eigen::Vector2d& near_px, int reach_px) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  const int u0 = static_cast<int>(std::lround(near_px.x())), v0 = static_cast<int>(std::lround(near_px.y()));
  for (int v = v0 - reach_px; v <= v0 + reach_px; ++v)
    for (int u = u0 - reach_px; u <= u0 + reach_px; ++u) {
      const double dark = std::max(0, 222 - picture.at(u, v));
      sum += dark * Eigen::Vector2d(u, v);
      weight += dark;
    }
  return sum / weight;
}

std::vector<test::Lens> lenses() {
  test::Lens bent;
  bent.k = {-0.28, 0.09, 0.001, -0.0007};
  test::Lens fisheye;
  fisheye.fx_px = fisheye.fy_px = 420;
  fisheye.model = test::LensModel::kEquidistant;
  fisheye.k = {-0.02, 0.004};
  test::Lens rational;
  rational.model = test::LensModel::kRational;
  rational.k = {0.4, -0.1, 0.0003, -0.0002, 0.01, 0.7, -0.05, 0.02};
  return {test::Lens{}, bent, fisheye, rational};
}

test::Viewpoint some_view(test::Random& random) {
  test::Viewpoint view;
  view.distance_m = random.uniform(0.6, 2.5);
  view.tilt_rad = random.uniform(0, 55) * kRadPerDeg;
  view.azimuth_rad = random.uniform(0, 360) * kRadPerDeg;
  view.roll_rad = random.uniform(-10, 10) * kRadPerDeg;
  view.off_axis_x_rad = random.uniform(-8, 8) * kRadPerDeg;
  view.off_axis_y_rad = random.uniform(-5, 5) * kRadPerDeg;
  return view;
}

TEST(SheetRenderer, MakesThePicturesOfTheTestsOwnRenderer) {
  test::Random random(11);
  for (const test::Lens& lens : lenses()) {
    SheetRenderer renderer(camera_of(lens), {black_sheet()}, without_noise());
    for (int i = 0; i < 4; ++i) {
      const test::Scene scene = scene_of(lens, some_view(random));
      const test::Picture expected = test::render(scene, 1);
      renderer.render(at_rest(scene.camera), false, 0);
      const Difference off = difference(renderer.luma(), expected.view());
      // At edges, of 170 grey levels and more, this renderer's blur is one of whole pixels, the other's a finer one.
      EXPECT_LE(off.largest_lsb, 14) << "view " << i;
      EXPECT_LE(off.rms_lsb, 0.3) << "view " << i;
    }
  }
}

TEST(SheetRenderer, PutsTheDotsWhereTheyAreToATwentiethOfAPixel) {
  test::Random random(12);
  double largest_px = 0;
  int alone = 0;
  for (const test::Lens& lens : lenses()) {
    SheetRenderer renderer(camera_of(lens), {black_sheet()}, without_noise());
    for (int i = 0; i < 20; ++i) {
      const test::Viewpoint view = some_view(random);
      const test::Scene scene = scene_of(lens, view);
      // Else something else that is dark lies within reach of a dot.
      if (view.distance_m > lens.fx_px / 400 || view.tilt_rad > 22 * kRadPerDeg) continue;
      const test::Picture other = test::render(scene, 1);
      renderer.render(at_rest(scene.camera), false, 0);
      for (const test::Disc& disc : scene.sheets[0].discs) {
        const Eigen::Vector2d truth_px = test::centroid_of_disc_px(lens, scene.camera, disc);
        const double radius_px = lens.fx_px * disc.radius_m / scene.camera.position_m[1];
        const int reach_px = static_cast<int>(std::ceil(radius_px + 2.5));
        if (truth_px.minCoeff() < reach_px + 1 || truth_px.x() > lens.width_px - reach_px - 2 ||
            truth_px.y() > lens.height_px - reach_px - 2)
          continue;
        // The tone curve moves the centroid of a dark disc's grey levels a little; of both alike.
        const double off_px =
            (dark_centroid(renderer.luma(), truth_px, reach_px) - dark_centroid(other.view(), truth_px, reach_px))
                .norm();
        largest_px = std::max(largest_px, off_px);
        EXPECT_LT((dark_centroid(renderer.luma(), truth_px, reach_px) - truth_px).norm(), 0.05);
        ++alone;
      }
    }
  }
  EXPECT_GT(alone, 30);
  EXPECT_LT(largest_px, 0.05);
}

TEST(SheetRenderer, ShowsWhatTheEstimatorFindsWithinWhatItClaims) {
  test::Random random(13);
  const test::Lens lens = lenses()[1];
  SheetRenderer renderer(camera_of(lens), {black_sheet()}, {.blur_px = 0.6, .noise_lsb = 2, .seed = 5});
  Localiser localiser(camera_of(lens), {.tracking = false});
  constexpr int kViews = 60;
  double nees = 0;
  int found = 0;
  for (int i = 0; i < kViews; ++i) {
    const test::CameraPose pose = test::look_at_landmark(some_view(random));
    renderer.render(at_rest(pose), false, static_cast<std::uint64_t>(i));
    Frame frame;
    frame.luma = renderer.luma();
    frame.set_exposure(mono_from_ns(1'000'000'000 + i));
    const Fix& fix = localiser.process(frame);
    if (fix.reason != Reason::kNone) continue;
    ++found;
    const PoseEstimate& estimate = fix.main().pose();
    const Isometry3d truth = at_rest(pose).T_world_camera[1];
    Eigen::Matrix<double, 6, 1> error;
    error << estimate.T_landmark_camera.translation_m - truth.translation(),
        log_so3(truth.linear().transpose() * estimate.T_landmark_camera.rotation);
    nees += error.dot(estimate.covariance.ldlt().solve(error)) / 6;
  }
  EXPECT_GE(found, kViews * 9 / 10);
  // 1 for errors exactly as large as claimed; the mean of 60 times six squares scatters by 0.075. 0.89 was measured.
  EXPECT_LT(nees / found, 1.25);
  EXPECT_GT(nees / found, 0.6);
}

TEST(SheetRenderer, GivesTheSameNoiseForTheSameSeedAndFrameAndOtherNoiseForOthers) {
  const CameraModel camera;
  const ExposureMotion motion = at_rest(test::CameraPose{});
  SheetRenderer a(camera, {black_sheet()}, {.seed = 1}), b(camera, {black_sheet()}, {.seed = 1}),
      c(camera, {black_sheet()}, {.seed = 2});
  for (const std::uint64_t frame : {0U, 1U}) {
    a.render(motion, false, frame);
    b.render(motion, false, frame);
    c.render(motion, false, frame);
    EXPECT_EQ(difference(a.luma(), b.luma()).largest_lsb, 0);
    EXPECT_GT(difference(a.luma(), c.luma()).rms_lsb, 1);
  }
  b.render(motion, false, 0);
  EXPECT_GT(difference(a.luma(), b.luma()).rms_lsb, 1) << "frames 1 and 0";
}

TEST(SheetRenderer, HasNoiseOfTheSizeAsked) {
  const CameraModel camera;
  SheetRenderer renderer(camera, {black_sheet()}, {.noise_lsb = 4});
  SheetRenderer clean(camera, {black_sheet()}, {.noise_lsb = 0});
  const ExposureMotion motion = at_rest(test::CameraPose{});
  renderer.render(motion, false, 3);
  clean.render(motion, false, 3);
  const double rms_lsb = difference(renderer.luma(), clean.luma()).rms_lsb;
  // Most of the picture is the wall, at grey level 149: shot noise in light, less of it in sRGB.
  EXPECT_NEAR(rms_lsb, 4, 0.4);
}

TEST(SheetRenderer, ExposesEachRowOfARollingShutterAtItsOwnMoment) {
  const CameraModel camera;
  const test::CameraPose pose = test::look_at_landmark({.distance_m = 0.8});
  const Isometry3d middle = at_rest(pose).T_world_camera[1];
  constexpr double kRowTime_s = 30e-6, kHalf_s = kRowTime_s * 479 / 2;
  const auto moved = [&](double after_s) {
    Isometry3d T = middle;
    T.linear() = middle.linear() * Eigen::AngleAxisd(1.5 * after_s, Eigen::Vector3d::UnitY()).toRotationMatrix();
    T.translation() += Eigen::Vector3d(0.8, -0.3, 0) * after_s;
    return T;
  };
  SheetRenderer rolling(camera, {black_sheet()}, {.noise_lsb = 0, .row_time_s = kRowTime_s});
  rolling.render({{moved(-kHalf_s), middle, moved(kHalf_s)}, std::chrono::duration<double>(kHalf_s)}, false, 0);
  SheetRenderer still(camera, {black_sheet()}, {.noise_lsb = 0});
  for (const int row : {150, 200, 239, 280, 330}) {
    const Isometry3d T = moved((row - 239.5) * kRowTime_s);
    still.render({{T, T, T}, {}}, false, 0);
    for (int u = 0; u < camera.width_px; ++u)
      // The rows that are blurred into it differ by their own moments.
      EXPECT_NEAR(rolling.luma().at(u, row), still.luma().at(u, row), 3) << u << ", " << row;
  }
  still.render({{middle, middle, middle}, {}}, false, 0);
  EXPECT_GT(difference(rolling.luma(), still.luma()).largest_lsb, 40);
}

TEST(SheetRenderer, MeansTheLightOfTheMomentsOfAnExposure) {
  const CameraModel camera;
  const Isometry3d middle = at_rest(test::look_at_landmark({.distance_m = 0.8})).T_world_camera[1];
  constexpr double kExposure_s = 0.01;
  const auto moved = [&](double after_s) {
    Isometry3d T = middle;
    T.translation() += Eigen::Vector3d(0.7, 0, 0) * after_s;  // 6 px in all
    return T;
  };
  SheetRenderer blurred(camera, {black_sheet()}, {.noise_lsb = 0, .exposure_s = kExposure_s});
  const std::chrono::duration<double> half_s(kExposure_s / 2);
  blurred.render({{moved(-half_s.count()), middle, moved(half_s.count())}, half_s}, false, 0);
  SheetRenderer still(camera, {black_sheet()}, {.noise_lsb = 0});
  constexpr int kMoments = 64, kRow = 239;
  std::vector<double> light(640, 0);
  for (int i = 0; i < kMoments; ++i) {
    const Isometry3d T = moved(((i + 0.5) / kMoments - 0.5) * kExposure_s);
    still.render({{T, T, T}, {}}, false, 0);
    for (int u = 0; u < 640; ++u)
      light[static_cast<std::size_t>(u)] +=
          test::light_from_grey(still.luma().at(u, kRow), test::ToneCurve::kSrgb) / kMoments;
  }
  for (int u = 0; u < 640; ++u)
    EXPECT_NEAR(blurred.luma().at(u, kRow),
                test::grey_from_light(light[static_cast<std::size_t>(u)], test::ToneCurve::kSrgb), 6)
        << u;
}

TEST(SheetRenderer, ShowsTheNearerOfTwoSheetsAndNoneFromBehind) {
  const CameraModel camera;
  HungSheet far = black_sheet(), behind = black_sheet();
  far.T_world_sheet.translation().y() = -1;  // hidden by the one at the origin
  behind.T_world_sheet.translation().y() = 0.3;
  behind.T_world_sheet.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  SheetRenderer all(camera, {black_sheet(), far, behind}, without_noise());
  SheetRenderer one(camera, {black_sheet()}, without_noise());
  const ExposureMotion motion = at_rest(test::CameraPose{});
  all.render(motion, false, 0);
  one.render(motion, false, 0);
  EXPECT_EQ(difference(all.luma(), one.luma()).largest_lsb, 0);
}

TEST(SheetRenderer, LeavesNothingOfTheFrameBefore) {
  const CameraModel camera;
  SheetRenderer used(camera, {black_sheet()}, without_noise()), fresh(camera, {black_sheet()}, without_noise());
  used.render(at_rest(test::look_at_landmark({.distance_m = 0.7})), false, 0);
  used.render(at_rest(test::look_at_landmark({.distance_m = 0.7})), true, 1);
  const ExposureMotion aside = at_rest(test::look_at_landmark({.distance_m = 1.3, .off_axis_x_rad = 0.2}));
  used.render(at_rest(test::look_at_landmark({.distance_m = 0.5})), false, 2);
  used.render(aside, false, 3);
  fresh.render(aside, false, 3);
  EXPECT_EQ(difference(used.luma(), fresh.luma()).largest_lsb, 0);
}

TEST(SheetRenderer, ShowsNothingButTheCoverWhenHidden) {
  const CameraModel camera;
  SheetRenderer renderer(camera, {black_sheet()}, without_noise());
  renderer.render(at_rest(test::CameraPose{}), true, 0);
  for (int v = 0; v < camera.height_px; v += 7)
    for (int u = 0; u < camera.width_px; ++u) ASSERT_EQ(renderer.luma().at(u, v), renderer.luma().at(0, 0));
}

TEST(SheetRenderer, GivesCodedSheetsColourAndOthersNone) {
  const CameraModel camera;
  HungSheet coded = black_sheet();
  coded.inks[2] = {0.5F, 0.02F, 0.03F};  // P3, at the viewer's left
  SheetRenderer renderer(camera, {coded}, without_noise());
  renderer.render(at_rest(test::CameraPose{}), false, 0);
  const ChromaView chroma = renderer.chroma();
  ASSERT_FALSE(chroma.empty());
  const int reach = static_cast<int>(std::lround(0.080 * camera.fx_px)) / 2;
  EXPECT_GT(chroma.cr_at(160 - reach, 120), 170) << "red";
  EXPECT_LT(chroma.cb_at(160 - reach, 120), 120);
  EXPECT_NEAR(chroma.cr_at(160 + reach, 120), 128, 1) << "black";
  EXPECT_NEAR(chroma.cr_at(5, 5), 128, 1) << "wall";
  SheetRenderer grey(camera, {black_sheet()}, without_noise());
  EXPECT_TRUE(grey.chroma().empty());
}

TEST(SheetRenderer, AllocatesNothingPerFrame) {
  const CameraModel camera;
  SheetRenderer renderer(camera, {black_sheet(), black_sheet()}, {});
  const test::AllocationGuard guard;
  renderer.render(at_rest(test::CameraPose{}), false, 0);
  renderer.render(at_rest(test::CameraPose{}), true, 1);
  renderer.render(at_rest(test::CameraPose{}), false, 2);
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace ninedot
