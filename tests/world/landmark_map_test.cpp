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

TEST(LandmarkMap, TellsByHowMuchASheetIsOutOfUpright) {
  const Transform<frame::World, frame::Landmark> upright = place_upright({1, 2, 3}, -2.5);
  EXPECT_NEAR(heading_rad(upright), -2.5, 1e-12);
  EXPECT_NEAR(lean_rad(upright), 0, 1e-7);
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d::UnitX().eval(), Eigen::Vector3d::UnitY().eval()}) {
    const Transform<frame::World, frame::Landmark> turned{upright.rotation * exp_so3(0.25 * axis),
                                                          upright.translation_m};
    EXPECT_NEAR(heading_rad(turned), -2.5, 1e-12) << axis.transpose();
    EXPECT_NEAR(lean_rad(turned), 0.25, 1e-12) << axis.transpose();
  }
}

TEST(LandmarkMap, IsOneBlackAndWhiteLandmarkAtTheOriginUnlessTold) {
  const LandmarkMap map;
  ASSERT_EQ(map.landmarks().size(), 1U);
  ASSERT_NE(map.find(0), nullptr);
  EXPECT_TRUE(map.find(0)->code.empty());
}

TEST(LandmarkMap, FindsLandmarksByTheirIdentity) {
  const LandmarkMap map({{9, "", place_upright({9, 0, 0}, 0)}, {2, "", place_upright({2, 0, 0}, 0)}});
  ASSERT_NE(map.find(9), nullptr);
  EXPECT_EQ(map.find(9)->T_world_landmark.translation_m.x(), 9);
  EXPECT_EQ(map.find(2)->T_world_landmark.translation_m.x(), 2);
  EXPECT_EQ(map.find(3), nullptr);
  EXPECT_DEATH(LandmarkMap({{1, "", {}}, {1, "", {}}}), "contract");
}

}  // namespace
}  // namespace ninedot
