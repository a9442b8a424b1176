#include "geometry/landmark.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

// X0 points to the viewer's left, Z0 up.
TEST(LandmarkGeometry, P1IsLowestP3LeftP5TopP7RightAndP9InTheMiddle) {
  const LandmarkGeometry landmark{.ring_radius_m = 0.08};
  EXPECT_LT((landmark.centre_m(0) - Eigen::Vector2d(0, -0.08)).norm(), 1e-15);
  EXPECT_LT((landmark.centre_m(2) - Eigen::Vector2d(0.08, 0)).norm(), 1e-15);
  EXPECT_LT((landmark.centre_m(4) - Eigen::Vector2d(0, 0.08)).norm(), 1e-15);
  EXPECT_LT((landmark.centre_m(6) - Eigen::Vector2d(-0.08, 0)).norm(), 1e-15);
  EXPECT_EQ(landmark.centre_m(kCentreDot), Eigen::Vector2d(0, 0));
}

TEST(LandmarkGeometry, RingDotsAre45DegApartClockwiseForTheViewer) {
  const LandmarkGeometry landmark;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
    const Eigen::Vector2d a = landmark.centre_m(dot), b = landmark.centre_m((dot + 1) % kRingDotCount);
    EXPECT_NEAR(a.norm(), landmark.ring_radius_m, 1e-15);
    EXPECT_NEAR(a.dot(b) / a.squaredNorm(), std::sqrt(0.5), 1e-12);
    // The viewer sees x to the right = -X0 and y down = -Z0, where a positive cross product is clockwise.
    EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0);
  }
}

TEST(LandmarkGeometry, OnlyTheCentreDotHasTheCentreRadius) {
  const LandmarkGeometry landmark{.dot_radius_m = 0.01, .centre_radius_m = 0.02};
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) EXPECT_EQ(landmark.radius_m(dot), 0.01);
  EXPECT_EQ(landmark.radius_m(kCentreDot), 0.02);
}

}  // namespace
}  // namespace ninedot
