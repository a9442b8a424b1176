#include "world/landmark_map.h"

#include <gtest/gtest.h>

#include <numbers>

namespace ninedot {
namespace {

TEST(LandmarkMap, IsTheIdentityForALandmarkAtTheOriginWithoutHeading) {
  const auto T = place_upright(Eigen::Vector3d::Zero(), 0);
  EXPECT_TRUE(T.rotation.isApprox(Eigen::Matrix3d::Identity(), 1e-15));
  EXPECT_TRUE(T.translation_m.isZero());
}

TEST(LandmarkMap, TurnsTheSheetAboutTheWorldsZAndKeepsItUpright) {
  const auto T = place_upright({1, 2, 3}, std::numbers::pi / 2);
  // One metre in front of the sheet (+Y of S0) is one metre towards -X of the world at a heading of 90 degrees.
  EXPECT_TRUE((T * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0, 2, 3), 1e-12));
  EXPECT_TRUE((T * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1, 2, 4), 1e-12));
}

}  // namespace
}  // namespace ninedot
