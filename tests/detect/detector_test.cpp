#include "detect/detector.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "detect/homography.h"
#include "tests/detect/sharpened_spots.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

test::Scene scene_at(const test::Viewpoint& viewpoint, double noise_lsb = 1.5) {
  test::Scene scene;
  scene.camera = test::look_at_landmark(viewpoint);
  set_noise(scene.sensor, noise_lsb);
  return scene;
}

/// Where a point of the sheet appears, from the renderer's pose alone.
Eigen::Vector2d pixel_of(const test::Scene& scene, const Eigen::Vector2d& plane_m) {
  const auto& q = scene.camera.quaternion_wxyz;
  const auto& p = scene.camera.position_m;
  const Eigen::Vector3d in_camera = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).conjugate() *
                                    (Eigen::Vector3d(plane_m.x(), 0, plane_m.y()) - Eigen::Vector3d(p[0], p[1], p[2]));
  return {720 * in_camera.x() / in_camera.z() + 319.5, 720 * in_camera.y() / in_camera.z() + 239.5};
}

/// Every dot that is reported as seen lies where its number says.
void expect_dots_in_place(const test::Scene& scene, const LandmarkObservation& seen, double tolerance_px) {
  const LandmarkGeometry landmark;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!seen.dots[dot].seen) continue;
    const Eigen::Vector2d expected = pixel_of(scene, landmark.centre_m(dot));
    EXPECT_LT((seen.dots[dot].centroid_px - expected).norm(), tolerance_px) << "P" << dot + 1;
  }
}

/// The outline of a dot in the picture: the axes of an ellipse through points of it.
struct Outline {
  double semi_major_px, semi_minor_px, angle_rad;
};
Outline outline_of(const test::Scene& scene, std::size_t dot) {
  const LandmarkGeometry landmark;
  Eigen::Vector2d middle(0, 0);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 360; ++i) {
    const double a_rad = i * kDegree;
    points.push_back(pixel_of(
        scene, landmark.centre_m(dot) + landmark.radius_m(dot) * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad))));
    middle += points.back() / 360;
  }
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points) spread += (point - middle) * (point - middle).transpose() / 360;
  // Of a circle's points a coordinate's variance is r^2 / 2.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  const Eigen::Vector2d along = axes.eigenvectors().col(1);
  return {std::sqrt(2 * axes.eigenvalues()(1)), std::sqrt(2 * axes.eigenvalues()(0)), std::atan2(along.y(), along.x())};
}

struct View {
  const char* name;
  test::Viewpoint viewpoint;
  int min_seen;
};

class Views : public testing::TestWithParam<View> {};

TEST_P(Views, AreFoundWithEveryDotNumberedRight) {
  const test::Scene scene = scene_at(GetParam().viewpoint);
  const test::Picture picture = test::render(scene, 1);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen.has_value()) << GetParam().name;
  EXPECT_GE(seen->front().seen_count, GetParam().min_seen);
  // The centre of a projected disc is not its centre's projection: up to r^2 sin t cos t / f, 2.6 px at 0.3 m.
  expect_dots_in_place(scene, seen->front(), 0.4 + 0.8 / GetParam().viewpoint.distance_m);
  const auto again = detector.find_landmark_near(picture.view(), {seen->front(), ForecastNumbers::kByPriors});
  ASSERT_TRUE(again.has_value());
  expect_dots_in_place(scene, *again, 0.4 + 0.8 / GetParam().viewpoint.distance_m);
}

TEST(Detector, TellsTheEllipseOfEachDot) {
  for (const double azimuth_rad : {0.3, 1.2, 2.5, 4.0}) {
    const test::Scene scene = scene_at({.distance_m = 1, .tilt_rad = 55 * kDegree, .azimuth_rad = azimuth_rad}, 0.5);
    const test::Picture picture = test::render(scene, 1);
    Detector detector(CameraModel{}, LandmarkGeometry{});
    const auto seen = detector.find_landmarks(picture.view());
    ASSERT_TRUE(seen.has_value()) << azimuth_rad;
    int judged = 0;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      const DotObservation& found = seen->front().dots[dot];
      if (!found.seen) continue;
      ++judged;
      const Outline expected = outline_of(scene, dot);
      // Blur and whole pixels widen the narrow way of a dot of 9 px by some percent.
      EXPECT_NEAR(found.semi_major_px / expected.semi_major_px, 1, 0.08) << azimuth_rad << " P" << dot + 1;
      EXPECT_NEAR(found.semi_minor_px / expected.semi_minor_px, 1, 0.15) << azimuth_rad << " P" << dot + 1;
      EXPECT_LT(std::abs(std::sin(found.angle_rad - expected.angle_rad)), 0.08) << azimuth_rad << " P" << dot + 1;
    }
    EXPECT_GE(judged, 8);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Detector, Views,
    testing::Values(View{"near", {.distance_m = 0.3, .tilt_rad = 20 * kDegree}, 9},
                    View{"middle", {.distance_m = 1.5, .tilt_rad = 30 * kDegree, .azimuth_rad = 2}, 9},
                    View{"far", {.distance_m = 5, .tilt_rad = 20 * kDegree}, 8},
                    View{"farthest", {.distance_m = 7, .tilt_rad = 20 * kDegree}, 3},
                    View{"steep", {.distance_m = 1.5, .tilt_rad = 75 * kDegree}, 6},
                    View{"steep from above", {.distance_m = 1.0, .tilt_rad = 65 * kDegree, .azimuth_rad = 1.2}, 7},
                    View{"rolled", {.distance_m = 2, .tilt_rad = 10 * kDegree, .roll_rad = 20 * kDegree}, 9},
                    View{"in the corner",
                         {.distance_m = 1.5,
                          .tilt_rad = 25 * kDegree,
                          .off_axis_x_rad = 17 * kDegree,
                          .off_axis_y_rad = 12 * kDegree},
                         9}),
    [](const auto& param_info) {
      std::string name = param_info.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

/// Far away the point spread makes the small dots paler than P9, and a tone curve more so.
TEST(Detector, FindsFadedDotsAtSevenMetres) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  int found = 0, asked = 0;
  for (const auto tone : {test::ToneCurve::kLinear, test::ToneCurve::kSrgb}) {
    for (std::uint64_t seed = 0; seed < 12; ++seed, ++asked) {
      const double turn = static_cast<double>(seed) / 12;
      test::Scene scene = scene_at({.distance_m = 7,
                                    .tilt_rad = (10 + 20 * turn) * kDegree,
                                    .azimuth_rad = (seed % 2 == 0 ? 0 : 180 * kDegree) + 0.3 * (turn - 0.5),
                                    .roll_rad = 15 * kDegree * (1 - 2 * turn)},
                                   2.0);
      scene.sensor.tone = tone;
      scene.sensor.point_spread_px = 0.7;
      found += detector.find_landmarks(test::render(scene, seed).view()).has_value();
    }
  }
  EXPECT_GE(found, asked - 1);
}

TEST(Detector, NumbersTheRingByTheExpectedRoll) {
  test::Scene scene = scene_at({.distance_m = 1.2, .tilt_rad = 15 * kDegree, .roll_rad = 90 * kDegree});
  const test::Picture picture = test::render(scene, 1);
  Detector upright(CameraModel{}, LandmarkGeometry{});
  const auto wrong = upright.find_landmarks(picture.view());
  ASSERT_TRUE(wrong.has_value());
  EXPECT_GT((wrong->front().dots[0].centroid_px - pixel_of(scene, LandmarkGeometry{}.centre_m(0))).norm(), 20);
  const double roll_rad = 90 * kDegree;
  bool found = false;
  for (const double sign : {1.0, -1.0}) {
    Detector lying(CameraModel{}, LandmarkGeometry{}, {.upright = {.expected_roll_rad = sign * roll_rad}});
    const auto right = lying.find_landmarks(picture.view());
    ASSERT_TRUE(right.has_value());
    found =
        found || (right->front().dots[0].centroid_px - pixel_of(scene, LandmarkGeometry{}.centre_m(0))).norm() < 1.5;
  }
  EXPECT_TRUE(found);
}

TEST(Detector, RowStrideDoesNotMatter) {
  const test::Picture picture = test::render(scene_at({.distance_m = 1.2}), 1);
  std::vector<std::uint8_t> wide(static_cast<std::size_t>(700 * 480), 77);
  for (int y = 0; y < 480; ++y) std::copy_n(picture.view().row(y), 640, wide.data() + y * 700);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto a = detector.find_landmarks(picture.view());
  ASSERT_TRUE(a.has_value());
  const LandmarkObservation narrow = a->front();
  const auto b = detector.find_landmarks({wide.data(), 640, 480, 700});
  ASSERT_TRUE(b.has_value());
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    EXPECT_EQ(narrow.dots[dot].centroid_px, b->front().dots[dot].centroid_px);
}

class Hidden : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(Hidden, SheetIsFoundFromWhatIsLeft) {
  const auto [fraction, direction_deg] = GetParam();
  test::Scene scene = scene_at({.distance_m = 1.2, .tilt_rad = 20 * kDegree});
  scene.board.hidden_fraction = fraction;
  scene.board.direction_rad = direction_deg * kDegree;
  const test::Picture picture = test::render(scene, 4);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen.has_value());
  // A dot that lacks a tenth of its area passes as whole; its centroid is then off by up to a third of its 7.5 px
  // radius.
  expect_dots_in_place(scene, seen->front(), 2.5);
}

INSTANTIATE_TEST_SUITE_P(Detector, Hidden,
                         testing::Combine(testing::Values(0.1, 0.2, 0.3, 0.4),
                                          testing::Values(0.0, 45.0, 90.0, 180.0, 270.0)));

/// Three dots of the ring, and a sliver of P9 that tells nothing.
TEST(Detector, ShowsThreeDotsOfARingWhereNothingElseIsInSight) {
  const auto look = [](double hidden_fraction, bool is_there) {
    test::Scene scene = scene_at({.distance_m = 1.2, .tilt_rad = 20 * kDegree});
    scene.board.hidden_fraction = hidden_fraction;
    if (!is_there) scene.sheets.clear();
    return std::pair(scene, test::render(scene, 4));
  };
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto [scene, picture] = look(0.62, true);
  EXPECT_FALSE(detector.find_landmarks(picture.view()).has_value()) << "too little to be one";
  const auto three = detector.three_dots();
  ASSERT_TRUE(three.has_value());
  EXPECT_EQ(three->seen_count, 3);
  expect_dots_in_place(scene, *three, 2.5);
  EXPECT_TRUE(detector.find_landmarks(look(0.3, true).second.view()).has_value());
  EXPECT_FALSE(detector.three_dots().has_value()) << "the last search has found one";
  EXPECT_FALSE(detector.find_landmarks(picture.view()).has_value());
  EXPECT_FALSE(detector.find_landmarks(look(0, false).second.view()).has_value());
  EXPECT_FALSE(detector.three_dots().has_value()) << "the last search has seen none";
}

TEST(Detector, FindsTheLandmarkAcrossAHardShadowAndThroughHaze) {
  test::Scene scene = scene_at({.distance_m = 1.5, .tilt_rad = 20 * kDegree});
  scene.light.shadows.push_back({.direction_rad = 0.6, .offset_m = 0.02, .width_m = 0.07, .remaining = 0.25});
  scene.light.gradient_x_per_m = 2;
  Detector detector(CameraModel{}, LandmarkGeometry{});
  EXPECT_TRUE(detector.find_landmarks(test::render(scene, 1).view()).has_value());
  scene.haze = {.veil = 0.6, .level = 0.5};
  EXPECT_TRUE(detector.find_landmarks(test::render(scene, 1).view()).has_value());
}

TEST(Detector, TakesNoOtherPatternForTheLandmark) {
  std::vector<test::Sheet> patterns;
  for (const int dots : {6, 7, 9, 10, 12}) patterns.push_back(test::dot_ring_sheet(dots, true));
  patterns.push_back(test::dot_ring_sheet(8, false));
  patterns.push_back(test::dot_ring_sheet(8, true, 0.0127));
  patterns.push_back(test::dot_grid_sheet(6, 6, 0.034, 0.010));
  patterns.push_back(test::dot_grid_sheet(4, 4, 0.05, 0.0127));
  patterns.push_back(test::clock_sheet(0.1));
  patterns.push_back(test::polka_dots(120, 1.2, 0.01, 0.03, 3));
  Detector detector(CameraModel{}, LandmarkGeometry{});
  for (std::size_t i = 0; i < patterns.size(); ++i)
    for (const double distance_m : {0.8, 2.0, 4.0}) {
      test::Scene scene = scene_at({.distance_m = distance_m, .tilt_rad = 25 * kDegree});
      scene.sheets = {patterns[i]};
      EXPECT_FALSE(detector.find_landmarks(test::render(scene, i).view()).has_value())
          << "pattern " << i << " at " << distance_m << " m";
    }
}

TEST(Detector, SaysNothingThatIsNoNumberOfASharpenedPictureOfLonePixels) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto pixels = test::sharpened_spots(seed);
    const auto seen = detector.find_landmarks({pixels.data(), 640, 480, 640});
    EXPECT_TRUE(!seen || seen->front().H_ray_plane.allFinite()) << seed;
  }
}

/// Each count in the picture that makes it: texture of thin lines, a dense grid of equal dots, rings by the hundred.
TEST(Detector, CountsWhatItLeavesOut) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const test::Picture plain = test::render(scene_at({.distance_m = 1.2}), 1);
  ASSERT_TRUE(detector.find_landmarks(plain.view()).has_value());
  const WorkCounts none = detector.counts();
  EXPECT_EQ(none.runs_cut + none.blobs_cut + none.neighbours_cut + none.hypotheses_cut, 0U);

  std::vector<std::uint8_t> pixels(640 * 480, 220);
  const auto disc = [&](double x_px, double y_px, double radius_px) {
    for (int y = static_cast<int>(y_px - radius_px); y <= y_px + radius_px; ++y)
      for (int x = static_cast<int>(x_px - radius_px); x <= x_px + radius_px; ++x)
        if (std::hypot(x - x_px, y - y_px) < radius_px) pixels[static_cast<std::size_t>(y * 640 + x)] = 30;
  };
  const ImageView picture{pixels.data(), 640, 480, 640};
  // Blank rows where the noise is estimated: a picture that claims to have none.
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = i % 4 == 0 && i / 640 % 8 != 4 ? 30 : 220;
  (void)detector.find_landmarks(picture);
  const WorkCounts texture = detector.counts();
  EXPECT_GT(texture.runs_cut, 10000U);

  std::fill(pixels.begin(), pixels.end(), std::uint8_t{220});
  for (int i = 0; i < 2400; ++i) disc(12 + 10 * (i % 60), 12 + 10 * (i / 60), 2.9);
  (void)detector.find_landmarks(picture);
  const WorkCounts grid = detector.counts();
  EXPECT_GT(grid.blobs_cut, texture.blobs_cut + 500);
  EXPECT_GT(grid.neighbours_cut, texture.neighbours_cut);

  std::fill(pixels.begin(), pixels.end(), std::uint8_t{220});
  for (int i = 0; i < 130; ++i) {
    const double x_px = 28 + 44 * (i % 13), y_px = 28 + 44 * (i / 13);
    disc(x_px, y_px, 5.2);
    for (int k = 0; k < 5; ++k) disc(x_px + 16 * std::cos(k * 1.256), y_px + 16 * std::sin(k * 1.256), 2.6);
  }
  (void)detector.find_landmarks(picture);
  EXPECT_GT(detector.counts().hypotheses_cut, grid.hypotheses_cut);
}

/// A camera that rolls away slowly; when it has turned by more than half an eighth, a board hides a little of the
/// sheet.
TEST(Detector, KeepsATracksNumbersBeyondWhereThePriorsChangeTheirs) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const LandmarkGeometry landmark;
  std::optional<LandmarkForecast> forecast;
  int priors_disagree = 0;
  for (int frame = 0; frame <= 14; ++frame) {
    test::Scene scene =
        scene_at({.distance_m = 1.2, .tilt_rad = 15 * kDegree, .roll_rad = std::min(2.5 * frame, 25.0) * kDegree});
    if (frame == 12) scene.board.hidden_fraction = 0.08;
    const test::Picture picture = test::render(scene, static_cast<std::uint64_t>(frame));
    LandmarkObservation seen;
    if (forecast) {
      const auto near = detector.find_landmark_near(picture.view(), *forecast);
      ASSERT_TRUE(near.has_value()) << frame;
      seen = *near;
      const auto alone = detector.find_landmark_near(picture.view(), {seen, ForecastNumbers::kByPriors});
      ASSERT_TRUE(alone.has_value()) << frame;
      const bool renumbered_alone = (alone->dots[0].centroid_px - seen.dots[0].centroid_px).norm() > 5;
      priors_disagree += renumbered_alone ? 1 : 0;
      EXPECT_EQ(seen.numbering_chi2[0] > 0, renumbered_alone) << frame;
      EXPECT_TRUE(renumbered_alone || frame != 12) << "or this test says nothing";
    } else {
      const auto found = detector.find_landmarks(picture.view());
      ASSERT_TRUE(found.has_value());
      seen = found->front();
    }
    expect_dots_in_place(scene, seen, frame == 12 ? 2.5 : 1.1);
    EXPECT_LT((map_point(seen.H_ray_plane, landmark.centre_m(0)) * 720 + Eigen::Vector2d(319.5, 239.5) -
               pixel_of(scene, landmark.centre_m(0)))
                  .norm(),
              4)
        << frame;
    forecast = LandmarkForecast(seen, ForecastNumbers::kForetold);
  }
  EXPECT_GE(priors_disagree, 3);
}

TEST(Detector, TakesAPoseForAForecast) {
  const test::Scene scene = scene_at({.distance_m = 1.5, .tilt_rad = 0.4, .roll_rad = 170 * kDegree});
  const auto& [w, x, y, z] = scene.camera.quaternion_wxyz;
  const Transform<frame::Landmark, frame::Camera> T{Eigen::Quaterniond(w, x, y, z).toRotationMatrix(),
                                                    Eigen::Vector3d(scene.camera.position_m.data())};
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmark_near(test::render(scene, 1).view(), T.inverse());
  ASSERT_TRUE(seen.has_value());
  EXPECT_EQ(seen->seen_count, 9);
  expect_dots_in_place(scene, *seen, 1.0);
  EXPECT_GT(seen->numbering_chi2[0], 50) << "upside down, as the priors see it";
}

TEST(Detector, NumbersADotByThePriorsWhereTheForecastIsNotMetUnlessColoursHaveNumberedIt) {
  const test::Picture picture = test::render(scene_at({.distance_m = 1.5, .tilt_rad = 0.4}), 1);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen.has_value());
  for (const double foretold_bigger : {1.0, 1.3}) {  // 0.15 of the ring's radius is still met
    LandmarkForecast forecast(seen->front(), ForecastNumbers::kForetold);
    forecast.H_ray_plane.leftCols<2>() *= foretold_bigger;
    EXPECT_TRUE(detector.find_landmark_near(picture.view(), forecast).has_value()) << foretold_bigger;
    forecast.numbers = ForecastNumbers::kCertain;
    EXPECT_EQ(detector.find_landmark_near(picture.view(), forecast).has_value(), foretold_bigger < 1.1)
        << foretold_bigger;
  }
}

TEST(Detector, LooksNowhereForALandmarkBehindTheCameraOrNowhere) {
  const test::Picture picture = test::render(scene_at({.distance_m = 1.2}), 1);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  for (const double z_m : {-1.0, 0.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
    CameraFromLandmark T;
    T.translation_m = {0, 0, z_m};
    const auto seen = detector.find_landmark_near(picture.view(), T);
    ASSERT_FALSE(seen.has_value()) << z_m;
    EXPECT_EQ(seen.error().code, Errc::kNoLandmark);
  }
}

TEST(Detector, SaysWhenNothingIsThereAndWhenTheSizeIsWrong) {
  const std::vector<std::uint8_t> blank(640 * 480, 128);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  EXPECT_EQ(detector.find_landmarks({blank.data(), 640, 480, 640}).error().code, Errc::kNoLandmark);
  EXPECT_EQ(detector.find_landmarks({blank.data(), 320, 240, 640}).error().code, Errc::kFrameSize);
  EXPECT_EQ(
      detector.find_landmark_near({blank.data(), 320, 240, 640}, {LandmarkObservation{}, ForecastNumbers::kByPriors})
          .error()
          .code,
      Errc::kFrameSize);
  EXPECT_EQ(
      detector.find_landmark_near({blank.data(), 640, 480, 640}, {LandmarkObservation{}, ForecastNumbers::kByPriors})
          .error()
          .code,
      Errc::kNoLandmark);
}

}  // namespace
}  // namespace ninedot
