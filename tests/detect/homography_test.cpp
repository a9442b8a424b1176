#include "detect/homography.h"

#include <gtest/gtest.h>

#include <vector>

namespace ninedot {
namespace {

Eigen::Matrix3d some_homography() {
  Eigen::Matrix3d H;
  H << 900, 40, 300, -30, 850, 220, 0.4, -0.7, 1;
  return H;
}

std::vector<PlanePoint> matches_of(const Eigen::Matrix3d& H, std::initializer_list<Eigen::Vector2d> points) {
  std::vector<PlanePoint> matches;
  for (const Eigen::Vector2d& p : points) matches.push_back({p, map_point(H, p)});
  return matches;
}

TEST(Homography, IsRecoveredFromFivePoints) {
  const Eigen::Matrix3d truth = some_homography();
  Eigen::Matrix3d H;
  ASSERT_TRUE(fit_plane_map(matches_of(truth, {{0, 0}, {0.08, 0}, {0, 0.08}, {-0.08, 0.02}, {0.05, -0.07}}), H));
  EXPECT_LT((H - truth).norm() / truth.norm(), 1e-9);
}

TEST(Homography, FourPointsGiveAnAffineMap) {
  Eigen::Matrix3d truth = some_homography();
  truth(2, 0) = truth(2, 1) = 0;
  Eigen::Matrix3d H;
  ASSERT_TRUE(fit_plane_map(matches_of(truth, {{0, 0}, {0.08, 0}, {0, 0.08}, {-0.08, 0.02}}), H));
  EXPECT_LT((H - truth).norm() / truth.norm(), 1e-9);
}

TEST(Homography, RefusesTooFewPointsAndPointsOnALine) {
  Eigen::Matrix3d H;
  EXPECT_FALSE(fit_plane_map(matches_of(some_homography(), {{0, 0}, {0.08, 0}}), H));
  EXPECT_FALSE(fit_plane_map(matches_of(some_homography(), {{0, 0}, {0.04, 0.04}, {0.08, 0.08}}), H));
}

TEST(Homography, JacobianEqualsCentralDifferences) {
  const Eigen::Matrix3d H = some_homography();
  const Eigen::Vector2d at(0.03, -0.05);
  const Eigen::Matrix2d J = jacobian_of_map(H, at);
  constexpr double kStep = 1e-6;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
    const Eigen::Vector2d numeric = (map_point(H, at + step) - map_point(H, at - step)) / (2 * kStep);
    EXPECT_LT((J.col(axis) - numeric).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace ninedot
