#include "pose/full_solver.h"
#include "pose/pose_of_places.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/bench/crlb.h"
#include "tests/pose/solver_scene.h"

namespace ninedot {
namespace {

using test::Errors;
using test::errors_of;
using test::kDegree;
using test::pose_of;
using test::scene_at;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

class ToneCurves : public testing::TestWithParam<test::ToneCurve> {};

TEST_P(ToneCurves, ErrorIsNearTheCramerRaoBoundAndTheCovarianceHonest) {
  std::vector<double> ratios, normalised;
  double sum = 0;
  for (const double distance_m : {0.8, 1.5, 2.5, 4.0}) {
    for (const double tilt_deg : {20.0, 45.0}) {
      test::Scene scene =
          scene_at({.distance_m = distance_m, .tilt_rad = tilt_deg * kDegree, .azimuth_rad = distance_m});
      scene.sensor.tone = GetParam();
      const auto bound = bench::cramer_rao_bound(scene);
      ASSERT_TRUE(bound.has_value());
      const test::Exposure exposure = test::expose(scene);
      for (std::uint64_t seed = 0; seed < 8; ++seed) {
        const auto pose = pose_of(test::read_out(exposure, scene.sensor, seed));
        ASSERT_TRUE(pose.has_value()) << distance_m << ' ' << tilt_deg;
        const Errors e = errors_of(scene, *pose);
        ratios.push_back(e.pose.head<3>().norm() / bound->position_m);
        normalised.push_back(e.normalised2);
        sum += e.normalised2;
        EXPECT_EQ(pose->dots_used, 9);
        EXPECT_EQ(pose->occlusion_level, 0);
      }
    }
  }
  RecordProperty("median_error_over_bound", std::to_string(median(ratios)));
  EXPECT_LT(median(ratios), 1.5);
  const double mean = sum / static_cast<double>(normalised.size());
  RecordProperty("mean_normalised_error_squared", std::to_string(mean));
  EXPECT_GT(mean, 3.0);
  EXPECT_LT(mean, 9.0);
}

INSTANTIATE_TEST_SUITE_P(FullSolver, ToneCurves, testing::Values(test::ToneCurve::kLinear, test::ToneCurve::kSrgb),
                         [](const auto& param_info) {
                           return param_info.param == test::ToneCurve::kLinear ? "Linear" : "Srgb";
                         });

TEST(FullSolver, WhatLiesBeyondThePapersEdgeDoesNotPullDistantLandmarks) {
  double sum = 0, sum_of_squares = 0;
  constexpr int kFrames = 24;
  for (std::uint64_t seed = 0; seed < kFrames; ++seed) {
    test::Scene scene =
        scene_at({.distance_m = 5, .tilt_rad = 20 * kDegree, .azimuth_rad = 0.26 * static_cast<double>(seed)}, 1.0);
    scene.sensor.tone = test::ToneCurve::kLinear;
    const auto pose = pose_of(test::render(scene, seed));
    ASSERT_TRUE(pose.has_value());
    const double relative = pose->T_landmark_camera.translation_m.norm() / 5 - 1;
    sum += relative;
    sum_of_squares += relative * relative;
  }
  const double mean = sum / kFrames;
  const double sigma_of_mean = std::sqrt((sum_of_squares / kFrames - mean * mean) / kFrames);
  RecordProperty("bias_ppm", std::to_string(1e6 * mean));
  EXPECT_LT(std::abs(mean), 5e-5 + 3 * sigma_of_mean);
  EXPECT_LT(sigma_of_mean, 8e-5);
}

/// Motion makes each of the small dots longer one way, which is what a tilt across it does: by the way in which their
/// blurred outlines bend the two can be told apart, and the ring knows better anyway.
TEST(FullSolver, MotionOfADistantLandmarkIsNoTilt) {
  double sum = 0;
  int poses = 0;
  for (int i = 0; i < 12; ++i) {
    const test::Scene scene = scene_at({.distance_m = 5, .tilt_rad = 25 * kDegree, .azimuth_rad = 0.52 * i}, 1.0);
    const test::Exposure still = test::expose(scene);
    test::Exposure moved = still;
    for (std::size_t at = 1; at + 1 < still.light.size(); ++at)
      moved.light[at] = (still.light[at - 1] + still.light[at] + still.light[at + 1]) / 3;
    const auto pose = pose_of(test::read_out(moved, scene.sensor, static_cast<std::uint64_t>(i)));
    ASSERT_TRUE(pose.has_value()) << i;
    const Errors e = errors_of(scene, *pose);
    EXPECT_LT(e.pose.head<3>().norm(), 0.12) << i;
    sum += e.normalised2;
    ++poses;
  }
  RecordProperty("mean_normalised_error_squared", std::to_string(sum / poses));
  EXPECT_LT(sum / poses, 12);
}

/// Mean normalised error squared of twelve views from 2 m in such light, of 6 for honest ones.
double normalised2_in(const test::Light& light) {
  constexpr int kViews = 12;
  double sum = 0;
  for (int i = 0; i < kViews; ++i) {
    test::Scene scene = scene_at({.distance_m = 2, .tilt_rad = (15 + 3 * i) * kDegree, .azimuth_rad = 0.52 * i}, 2.0);
    scene.light = light;
    const auto pose = pose_of(test::render(scene, static_cast<std::uint64_t>(i) + 1));
    if (!pose)
      ADD_FAILURE() << i;
    else
      sum += errors_of(scene, *pose).normalised2;
  }
  testing::Test::RecordProperty("mean_normalised_error_squared", std::to_string(sum / kViews));
  return sum / kViews;
}

/// Ink is darker where the paper is, too.
TEST(FullSolver, SlopingLightMovesNoDots) {
  test::Light light;
  light.level = 0.55, light.gradient_x_per_m = 3, light.gradient_z_per_m = -3;
  EXPECT_LT(normalised2_in(light), 7);
}

TEST(FullSolver, SoftShadowsMoveDotsNoFurtherThanItSays) {
  test::Light light;
  light.shadows.push_back(
      {.direction_rad = 0.5, .offset_m = 0.01, .width_m = 0.12, .penumbra_m = 0.05, .remaining = 0.3});
  EXPECT_LT(normalised2_in(light), 7);
}

/// Edges of a shadow cross three or four of the dots, which say where they are all the same.
TEST(FullSolver, AHardShadowHardlyMovesTheDotsThatItCrosses) {
  constexpr int kViews = 24;
  double squares_m2 = 0;
  for (int i = 0; i < kViews; ++i) {
    test::Scene scene = scene_at({.distance_m = 1.5, .tilt_rad = 30 * kDegree, .azimuth_rad = 0.26 * i}, 0.2);
    scene.light.shadows = {
        {.direction_rad = 0.7 * i, .offset_m = 0.005 * (i - 12), .width_m = 0.07, .penumbra_m = 0.003}};
    const auto pose = pose_of(test::render(scene, static_cast<std::uint64_t>(i) + 1));
    ASSERT_TRUE(pose) << i;
    squares_m2 += errors_of(scene, *pose).pose.head<3>().squaredNorm();
  }
  const double error_m = std::sqrt(squares_m2 / kViews);
  RecordProperty("error_mm", std::to_string(1e3 * error_m));
  EXPECT_LT(error_m, 0.28e-3);  // 0.34 with dots cut into sectors
}

/// The penumbra of a beam before the sun is as wide as a dot: there the dots' places alone say where the camera is. Of
/// a shadow with a sharp edge the outlines' shapes do as well.
TEST(FullSolver, APenumbraLeavesThePoseToTheDotsPlaces) {
  constexpr int kViews = 24;
  double squares_m2 = 0;
  int by_places_in_penumbra = 0, by_places_in_hard_shadow = 0;
  for (int i = 0; i < kViews; ++i) {
    const auto seen_in = [&](double penumbra_m, test::Scene& scene) {
      scene = scene_at({.distance_m = 1.2, .tilt_rad = 25 * kDegree, .azimuth_rad = 0.26 * i}, 0.2);
      scene.light.shadows = {{.direction_rad = 0.7 * i,
                              .offset_m = 0.005 * (i - 12),
                              .width_m = 0.08,
                              .penumbra_m = penumbra_m,
                              .remaining = 0.3}};
      return test::candidates_in(test::render(scene, static_cast<std::uint64_t>(i) + 1));
    };
    const auto is_by_places = [](const PoseCandidates& candidates) {
      const PoseCandidate& candidate = candidates.list[0];
      const CameraFromLandmark T = candidate.pose.T_landmark_camera.inverse();
      const auto places = fit_to_places(candidate.dots, LandmarkGeometry{}, T);
      return places && (places->T_camera_landmark.translation_m - T.translation_m).norm() < 1e-7;
    };
    test::Scene scene;
    const auto soft = seen_in(0.03, scene);
    ASSERT_TRUE(soft) << i;
    squares_m2 += errors_of(scene, soft->list[0].pose).pose.head<3>().squaredNorm();
    by_places_in_penumbra += is_by_places(*soft);
    const auto hard = seen_in(0.003, scene);
    ASSERT_TRUE(hard) << i;
    by_places_in_hard_shadow += is_by_places(*hard);
  }
  const double error_m = std::sqrt(squares_m2 / kViews);
  RecordProperty("error_mm", std::to_string(1e3 * error_m));
  RecordProperty("penumbra", by_places_in_penumbra);
  RecordProperty("hard", by_places_in_hard_shadow);
  EXPECT_LT(error_m, 0.6e-3);
  EXPECT_GT(by_places_in_penumbra, kViews / 2);
  EXPECT_EQ(by_places_in_hard_shadow, 0);
}

/// Edges are looked for with what is left: where that is little the pose is the one without, and something stays.
TEST(FullSolver, LooksForAShadowsEdgesWithNoMoreThanItMay) {
  test::Scene scene = scene_at({.distance_m = 1.5, .tilt_rad = 30 * kDegree}, 0.2);
  scene.light.shadows = {{.direction_rad = 0.7, .offset_m = -0.055, .width_m = 0.07, .penumbra_m = 0.003}};
  const test::Picture picture = test::render(scene, 1);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  FullSolver solver(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen);
  int last_left = 0, kinds = 0;
  double last_variance_m2 = 0;
  for (int allowance = 26'000; allowance > 6'000; allowance -= 1'000) {
    int pixels = allowance;
    const auto solved = solver.solve(picture.view(), seen->front(), nullptr, pixels);
    if (!solved) break;
    EXPECT_GT(pixels, 0) << allowance;
    const double variance_m2 = solved->list[0].pose.covariance.diagonal().head<3>().sum();
    kinds += std::abs(variance_m2 - last_variance_m2) > 1e-3 * variance_m2;
    last_variance_m2 = variance_m2, last_left = pixels;
  }
  EXPECT_EQ(kinds, 2) << "with edges, and without";
  EXPECT_LT(last_left, 6'000);
}

TEST(FullSolver, HardShadowAcrossTheSheetCostsLessThanHalfAPercent) {
  test::Scene scene = scene_at({.distance_m = 2, .tilt_rad = 20 * kDegree});
  scene.light.shadows.push_back(
      {.direction_rad = 0.5, .offset_m = 0.01, .width_m = 0.06, .penumbra_m = 0.004, .remaining = 0.3});
  const auto pose = pose_of(test::render(scene, 2));
  ASSERT_TRUE(pose.has_value());
  EXPECT_LT(errors_of(scene, *pose).pose.head<3>().norm(), 0.005 * 2);
}

TEST(FullSolver, HiddenDotsAreReportedAndUncertaintyGrows) {
  test::Scene scene = scene_at({.distance_m = 1.2, .tilt_rad = 25 * kDegree});
  const auto whole = pose_of(test::render(scene, 3));
  ASSERT_TRUE(whole.has_value());
  scene.board.hidden_fraction = 0.4;
  const auto part = pose_of(test::render(scene, 3));
  ASSERT_TRUE(part.has_value());
  EXPECT_LT(part->dots_used, 9);
  EXPECT_GE(part->occlusion_level, 2);
  const auto position_variance = [](const PoseEstimate& pose) { return pose.covariance.diagonal().head<3>().sum(); };
  EXPECT_GT(position_variance(*part), position_variance(*whole));
  EXPECT_LT(errors_of(scene, *part).pose.head<3>().norm(), 0.005 * 1.2);
}

TEST(FullSolver, ReportsTheOtherSolutionOfADistantFrontalLandmark) {
  const auto near = pose_of(test::render(scene_at({.distance_m = 1, .tilt_rad = 40 * kDegree}), 5));
  ASSERT_TRUE(near.has_value());
  EXPECT_LT(near->ambiguity, 0.01);
  double most = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const auto far = pose_of(test::render(scene_at({.distance_m = 6, .tilt_rad = 8 * kDegree}, 4.0), seed));
    if (far) most = std::max(most, far->ambiguity);
  }
  EXPECT_GT(most, 0.05);
}

/// The sheet's normal is nearer to its mirror image about the line of sight than to the truth.
bool is_on_the_wrong_side(const test::Scene& scene, const PoseEstimate& pose) {
  const auto& [w, x, y, z] = scene.camera.quaternion_wxyz;
  const Eigen::Matrix3d true_R = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
  const Eigen::Vector3d sight = true_R.transpose() * Eigen::Vector3d(scene.camera.position_m.data()).normalized();
  const Eigen::Vector3d normal = true_R.row(1), found = pose.T_landmark_camera.rotation.row(1);
  return found.dot(2 * normal.dot(sight) * sight - normal) > found.dot(normal);
}

TEST(FullSolver, LooksAtTheMirrorImageAlsoWhereBothStartsAreOne) {
  // Far and nearly frontal: noise hides that the dots' centres allow two poses, but the outlines do.
  int poses = 0, wrong = 0, wrong_and_sure = 0;
  for (const double distance_m : {5.0, 6.5, 8.0})
    for (const double tilt_deg : {7.0, 12.0, 20.0})
      for (std::uint64_t seed = 0; seed < 8; ++seed) {
        const test::Scene scene = scene_at(
            {.distance_m = distance_m, .tilt_rad = tilt_deg * kDegree, .azimuth_rad = 0.8 * static_cast<double>(seed)},
            2.0);
        const auto pose = pose_of(test::render(scene, seed));
        if (!pose) continue;
        ++poses;
        if (!is_on_the_wrong_side(scene, *pose)) continue;
        ++wrong;
        if (pose->ambiguity < 1e-4) ++wrong_and_sure;
      }
  RecordProperty("poses", poses);
  RecordProperty("on_the_wrong_side", wrong);
  EXPECT_GT(poses, 50);
  EXPECT_GT(wrong, 0) << "the test shows nothing";
  EXPECT_EQ(wrong_and_sure, 0) << "of " << wrong << " on the wrong side, " << poses << " in all";
}

TEST(FullSolver, ErrsWithinItsCovarianceWhereViewsAreNearlyFrontal) {
  double sum = 0;
  int poses = 0, undetermined = 0;
  for (int i = 0; i < 40; ++i) {
    const test::Scene scene = scene_at(
        {.distance_m = 3 + 1.5 * std::fmod(0.12 * i, 1), .tilt_rad = 0.085 * i * kDegree, .azimuth_rad = 2.4 * i},
        1 + 2 * std::fmod(0.18 * i, 1));
    const auto pose = pose_of(test::render(scene, static_cast<std::uint64_t>(i)));
    undetermined += !pose;  // sideways by more than a tenth of the distance
    if (!pose) continue;
    const Errors e = errors_of(scene, *pose);
    if (pose->ambiguity > 0.01) continue;
    EXPECT_LT(e.normalised2, 36) << i;
    sum += e.normalised2;
    ++poses;
  }
  const double error_over_sigma = std::sqrt(sum / (6 * poses));
  RecordProperty("poses", poses);
  RecordProperty("error_over_sigma", std::to_string(error_over_sigma));
  EXPECT_LE(undetermined, 2);
  EXPECT_GE(poses, 18);
  EXPECT_GT(error_over_sigma, 0.8);
  EXPECT_LT(error_over_sigma, 1.15);
}

/// From in front a distant sheet's tilt is anyone's guess; direction and distance are not.
TEST(FullSolver, AnswersWithATiltThatItDoesNotKnowToWhoHasOtherLandmarks) {
  const test::Scene scene = scene_at({.distance_m = 7.5, .tilt_rad = 2 * kDegree}, 5);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  FullSolver alone(CameraModel{}, LandmarkGeometry{}),
      among_others(CameraModel{}, LandmarkGeometry{}, {.most_sigma = 1});
  int answered = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const test::Picture picture = test::render(scene, seed);
    const auto seen = detector.find_landmarks(picture.view());
    ASSERT_TRUE(seen);
    int pixels = WorkBudget{}.pixels;
    const auto refused = alone.solve(picture.view(), seen->front(), nullptr, pixels);
    if (refused) continue;
    EXPECT_EQ(refused.error().code, Errc::kPoseDegenerate);
    const auto answer = among_others.solve(picture.view(), seen->front(), nullptr, pixels);
    ASSERT_TRUE(answer) << seed;
    ++answered;
    const Eigen::Vector3d t_m = answer->list[0].pose.T_landmark_camera.inverse().translation_m;
    EXPECT_LT(t_m.head<2>().norm() / t_m.z(), 0.0005) << seed;
    EXPECT_NEAR(t_m.z(), 7.5, 0.3) << seed;
  }
  EXPECT_GT(answered, 0) << "or these pictures test nothing";
}

/// Dots of 2.2 to 2.4 px through a blur of a pixel: while blur and offset settle a dot may look like a quarter of a
/// pixel of ink, and is in sight all the same (else 49 of 60).
TEST(FullSolver, FindsThePoseOfDistantDots) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  FullSolver solver(CameraModel{}, LandmarkGeometry{}, {.most_sigma = 1, .pattern_px = 0.1});
  int seen_count = 0, solved = 0, right = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const double distance_m = CameraModel{}.fx_px * 0.0254 / (2.2 + 0.2 * static_cast<double>(seed) / 60);
    test::Scene scene =
        scene_at({.distance_m = distance_m, .tilt_rad = 0.2, .azimuth_rad = static_cast<double>(seed)}, 3);
    scene.sensor.point_spread_px = 1.0;
    const test::Picture picture = test::render(scene, seed);
    WorkBudget budget;
    const auto seen = detector.find_all_landmarks(picture.view(), budget);
    if (!seen) continue;
    ++seen_count;
    int pixels = WorkBudget{}.pixels;
    const auto answer = solver.solve(picture.view(), seen->front(), nullptr, pixels);
    if (!answer) continue;
    ++solved;
    right += std::abs(answer->list[0].pose.T_landmark_camera.inverse().translation_m.z() / distance_m - 1) < 0.03;
  }
  EXPECT_GE(seen_count, 55) << "or these pictures test nothing";
  EXPECT_GE(solved, seen_count - 1);
  EXPECT_EQ(right, solved);
}

TEST(FullSolver, ReportsTheFoundingPapersQuantities) {
  const auto pose = pose_of(test::render(scene_at({.distance_m = 1.3, .tilt_rad = 35 * kDegree}), 5));
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->ellipse.distance_m, 1.3, 0.005);
  EXPECT_NEAR(pose->ellipse.tilt_phi_rad, 35 * kDegree, 0.01);
}

TEST(FullSolver, ThinsThePixelsOfALandmarkThatFillsThePictureAndAnswersNothingWithoutAny) {
  const test::Scene scene = scene_at({.distance_m = 0.3, .tilt_rad = 0.3});
  const test::Picture picture = test::render(scene, 1);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen.has_value());
  FullSolver solver(CameraModel{}, LandmarkGeometry{});
  int plenty = 1'000'000, few = 15'000, none = 0;
  const auto all = solver.solve(picture.view(), seen->front(), nullptr, plenty);
  const auto thinned = solver.solve(picture.view(), seen->front(), nullptr, few);
  ASSERT_TRUE(all && thinned);
  EXPECT_GT(1'000'000 - plenty, 16'000) << "or this picture tests nothing";
  EXPECT_GT(few, 0) << "it took what was there";
  const auto apart_m =
      (all->list[0].pose.T_landmark_camera.translation_m - thinned->list[0].pose.T_landmark_camera.translation_m)
          .norm();
  EXPECT_LT(apart_m, 1e-4 * 0.3);
  EXPECT_FALSE(solver.solve(picture.view(), seen->front(), nullptr, none).has_value());
}

/// Every answer that a small allowance leaves has its mirror image refined where a large one does, and is the same.
TEST(FullSolver, HasNoAnswerRatherThanOneWhoseMirrorImageItHadNoPixelsLeftFor) {
  const test::Picture picture = test::render(scene_at({.distance_m = 7, .tilt_rad = 0.15}), 1);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen.has_value());
  FullSolver solver(CameraModel{}, LandmarkGeometry{});
  int plenty = 1'000'000;
  const auto all = solver.solve(picture.view(), seen->front(), nullptr, plenty);
  ASSERT_TRUE(all && all->list.size() == 2 && all->list[1].refined) << "or this picture tests nothing";
  int refused = 0;
  for (int allowed = 100; allowed < 1'000'000 - plenty + 500; allowed += 100) {
    int pixels = allowed;
    const auto answer = solver.solve(picture.view(), seen->front(), nullptr, pixels);
    refused += answer ? 0 : 1;
    if (!answer) continue;
    ASSERT_EQ(answer->list.size(), 2U) << allowed;
    EXPECT_TRUE(answer->list[1].refined) << allowed;
    EXPECT_EQ(answer->list[0].pose.T_landmark_camera.translation_m, all->list[0].pose.T_landmark_camera.translation_m)
        << allowed;
  }
  EXPECT_GT(refused, 0);
}

TEST(FullSolver, RefusesAPictureThatShowsNoOutlines) {
  const test::Picture picture = test::render(scene_at({.distance_m = 1}), 1);
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen.has_value());
  const std::vector<std::uint8_t> blank(640 * 480, 128);
  FullSolver solver(CameraModel{}, LandmarkGeometry{});
  int pixels = WorkBudget{}.pixels;
  const auto pose = test::best_pose(solver.solve({blank.data(), 640, 480, 640}, seen->front(), nullptr, pixels));
  ASSERT_FALSE(pose.has_value());
  EXPECT_EQ(pose.error().code, Errc::kPoseDegenerate);
}

}  // namespace
}  // namespace ninedot
