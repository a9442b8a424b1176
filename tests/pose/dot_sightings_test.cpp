// What each dot's outline says of its own middle: all of them together are the pose, as certain as it is.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "tests/pose/first_fit.h"
#include "world/sighting_fit.h"

namespace ninedot {
namespace {

struct Solved {
  PoseCandidate candidate;
  LandmarkSighting sighting;
};

std::optional<Solved> solve(const test::Scene& scene, std::uint64_t noise_seed) {
  const auto best = test::first_fit(test::render(scene, noise_seed).view());
  if (!best) return std::nullopt;
  return Solved{*best, {0, best->pose.T_landmark_camera.inverse(), best->dots}};
}

test::Scene scene_from(const test::Viewpoint& viewpoint) { return test::scene_of(test::nine_dot_sheet(), viewpoint); }

SightingFit fit_at_own_pose(const Solved& solved) {
  const auto& T = solved.candidate.pose.T_landmark_camera;
  return fit_of_sighting(solved.sighting, {}, {T.rotation, T.translation_m}, LandmarkGeometry{});
}

const test::Viewpoint kViews[] = {{.distance_m = 1.0, .tilt_rad = 0.5, .azimuth_rad = 0.7},
                                  {.distance_m = 2.5, .tilt_rad = 0.7, .azimuth_rad = 2.5, .off_axis_x_rad = 0.2},
                                  {.distance_m = 4.0, .tilt_rad = 0.9, .azimuth_rad = 4.0}};

TEST(DotSightings, ArePlacedByThePoseThatTheyMake) {
  double sum = 0;
  int count = 0;
  for (const test::Viewpoint& view : kViews)
    for (std::uint64_t seed = 1; seed <= 12; ++seed, ++count) {
      const auto solved = solve(scene_from(view), seed);
      ASSERT_TRUE(solved) << view.distance_m;
      const SightingFit fit = fit_at_own_pose(*solved);
      EXPECT_EQ(fit.dots, 9);
      // How far their own best pose lies from that of the outlines, in sigmas: sizes and shapes add a little.
      const PoseStep step = fit.normal.ldlt().solve(fit.gradient);
      sum += step.dot(fit.normal * step);
    }
  EXPECT_LT(std::sqrt(sum / count), 0.8);  // of six freedoms, sqrt(6) of which would be an estimate of its own
}

TEST(DotSightings, AreTogetherAsCertainAsThePose) {
  for (const test::Viewpoint& view : kViews) {
    const auto solved = solve(scene_from(view), 1);
    ASSERT_TRUE(solved) << view.distance_m;
    const PoseInformation covariance = fit_at_own_pose(*solved).normal.inverse();
    const Matrix6d& whole = solved->candidate.pose.covariance;
    const double sigma_ratio =
        std::sqrt(covariance.topLeftCorner<3, 3>().trace() / whole.topLeftCorner<3, 3>().trace());
    EXPECT_GT(sigma_ratio, 0.9) << view.distance_m << " m";
    EXPECT_LT(sigma_ratio, 1.2) << view.distance_m << " m";
  }
}

/// Against the truth, chi^2 of each ray has two freedoms.
TEST(DotSightings, ScatterAboutTheTruthAsTheyClaim) {
  double sum = 0;
  int count = 0;
  for (const test::Viewpoint& view : kViews)
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const test::Scene scene = scene_from(view);
      const auto solved = solve(scene, seed);
      ASSERT_TRUE(solved);
      const auto& [position_m, q] = scene.camera;
      const WorldFromCamera truth{Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(),
                                  {position_m[0], position_m[1], position_m[2]}};
      sum += fit_of_sighting(solved->sighting, {}, truth, LandmarkGeometry{}).chi2;
      count += 18;
    }
  EXPECT_GT(sum / count, 0.7);
  EXPECT_LT(sum / count, 1.5);
}

TEST(DotSightings, OfDotsThatAreHiddenSayNothing) {
  test::Scene scene = scene_from(kViews[0]);
  scene.board.hidden_fraction = 0.25;
  const auto solved = solve(scene, 1);
  ASSERT_TRUE(solved);
  int hidden = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (solved->candidate.visible_share[dot] > 0) continue;
    EXPECT_TRUE(solved->candidate.dots[dot].information.isZero(0)) << dot;
    ++hidden;
  }
  EXPECT_GE(hidden, 1);
  EXPECT_LE(fit_at_own_pose(*solved).dots, 9 - hidden);
}

TEST(DotSightings, AreNumberedAnewByTurning) {
  DotSightings dots;
  for (std::size_t i = 0; i < kDotCount; ++i) dots[i].ray.x() = static_cast<double>(i);
  const DotSightings turned = renumbered(dots, 3);
  EXPECT_EQ(turned[0].ray.x(), 3);
  EXPECT_EQ(turned[6].ray.x(), 1);
  EXPECT_EQ(turned[kCentreDot].ray.x(), 8);
  EXPECT_EQ(renumbered(turned, -3)[5].ray.x(), 5);
}

}  // namespace
}  // namespace ninedot
