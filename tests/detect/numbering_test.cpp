#include "detect/numbering.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "detect/homography.h"
#include "detect/observation.h"

namespace ninedot {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// The sheet before the camera, turned about the optical axis, tilted about the picture's horizontal.
Eigen::Matrix3d view(double roll_rad, double tilt_rad = 0, double distance_m = 1) {
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  Eigen::Matrix3d H;
  H << -R.col(0), -R.col(1), Eigen::Vector3d(0.1, -0.05, distance_m);
  return H;
}

TEST(Reading, IsTheSameWhereTheSameDotsAreSeenInTheSamePlaces) {
  const LandmarkGeometry landmark;
  LandmarkObservation seen;
  seen.H_ray_plane = view(0.3, 0.5);
  for (DotObservation& dot : seen.dots) dot.seen = true;
  const auto is_same = [&](const LandmarkObservation& other) { return is_same_reading(seen, other, landmark); };
  LandmarkObservation other = seen;
  EXPECT_TRUE(is_same(other));
  other.H_ray_plane *= 1.7;  // the same map
  EXPECT_TRUE(is_same(other));
  EXPECT_FALSE(is_same(renumbered(seen, 1)));
  other.dots[4].seen = false;
  EXPECT_FALSE(is_same(other));
  other = seen;
  other.H_ray_plane = view(0.3, 0.5, 1.01);
  EXPECT_FALSE(is_same(other));
}

TEST(Numbering, TurnsDotsHomographyAndCostsTogether) {
  const LandmarkGeometry landmark;
  LandmarkObservation seen;
  seen.H_ray_plane = view(0.2, 0.5);
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    seen.dots[dot].centroid_px = 720 * map_point(seen.H_ray_plane, landmark.centre_m(dot));
  for (std::size_t k = 0; k < kRingDotCount; ++k) seen.numbering_chi2[k] = static_cast<double>(k);
  for (const int eighths : {-11, -1, 0, 1, 3, 7, 8, 13}) {
    const LandmarkObservation turned = renumbered(seen, eighths);
    const auto first = static_cast<std::size_t>((eighths + 16) % 8);
    EXPECT_EQ(turned.dots[0].centroid_px, seen.dots[first].centroid_px) << eighths;
    EXPECT_EQ(turned.numbering_chi2[0], static_cast<double>(first));
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      EXPECT_LT((turned.dots[dot].centroid_px - 720 * map_point(turned.H_ray_plane, landmark.centre_m(dot))).norm(),
                1e-9)
          << eighths << ": P" << dot + 1;
    EXPECT_EQ(turned.dots[kCentreDot].centroid_px, seen.dots[kCentreDot].centroid_px);
  }
}

TEST(Numbering, CostsAreSquaredRollsOverTheirSigmaAboveTheBest) {
  const LandmarkGeometry landmark;
  const double roll_rad = 10 * kDegree;
  const NumberingCosts costs = numbering_costs({}, view(roll_rad), landmark, {0, 14 * kDegree / 1.25});
  EXPECT_EQ(costs[0], 0);
  // Seen nearly from in front the neighbours need 45 degrees less or more of roll.
  const double best = std::pow(10.0 / 14, 2);
  const double least = std::pow(35.0 / 14, 2) - best, next = std::pow(55.0 / 14, 2) - best;
  EXPECT_NEAR(std::min(costs[1], costs[7]), least, 0.1);
  EXPECT_NEAR(std::max(costs[1], costs[7]), next, 0.1);
  const NumberingCosts lying = numbering_costs({}, view(roll_rad), landmark, {roll_rad + 45 * kDegree, 14 * kDegree});
  EXPECT_NE(std::min_element(lying.begin(), lying.end()), lying.begin());
}

TEST(Numbering, FollowsAForecastHoweverTheDotsAreNumberedNow) {
  const LandmarkGeometry landmark;
  LandmarkObservation seen;
  for (const double roll_deg : {-170.0, -25.0, 0.0, 25.0, 100.0}) {
    seen.H_ray_plane = view(roll_deg * kDegree, 0.6);
    for (int eighths = 0; eighths < 8; ++eighths)
      for (const double moved_deg : {-5.0, 0.0, 5.0}) {
        const LandmarkObservation now = renumbered(seen, eighths);
        const Eigen::Matrix3d forecast = view((roll_deg + moved_deg) * kDegree, 0.65, 1.05);
        const auto first = first_dot_by_forecast(now.H_ray_plane, forecast, landmark);
        ASSERT_TRUE(first.has_value());
        EXPECT_EQ((*first + eighths) % 8, 0) << roll_deg << ' ' << eighths << ' ' << moved_deg;
      }
  }
}

TEST(Numbering, FollowsNoForecastOfAnotherView) {
  const LandmarkGeometry landmark;
  EXPECT_FALSE(first_dot_by_forecast(view(0), view(20 * kDegree), landmark).has_value());
  EXPECT_FALSE(first_dot_by_forecast(view(0), view(0, 0, 1.3), landmark).has_value());
  EXPECT_FALSE(first_dot_by_forecast(view(0), Eigen::Matrix3d::Constant(std::nan("")), landmark).has_value());
  // Beyond an eighth's half another numbering is nearer: an alternative, not a motion.
  EXPECT_NE(first_dot_by_forecast(view(0), view(43 * kDegree), landmark).value_or(0), 0);
}

}  // namespace
}  // namespace ninedot
