#include "tests/bench/room_walk.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/renderer_optics.h"

namespace ninedot::bench {
namespace {

TEST(RoomWalk, GoesByTheWallAtItsSpeedAndDistance) {
  const RoomWalk unit({.label = "", .distance_m = 1.5, .speed_m_s = 0.8}, test::Random(3));
  const test::CameraPose before = unit.camera_at(0.2), after = unit.camera_at(0.7);
  EXPECT_NEAR(after.position_m[0] - before.position_m[0], 0.4, 1e-12);
  EXPECT_NEAR(unit.room().high_m[1] - before.position_m[1], 1.5, 1e-12);
  EXPECT_NEAR(std::abs(test::rotation_of(before).col(0).z()), 0, 0.01) << "upright";
  EXPECT_GT(test::rotation_of(before).col(2).y(), 0.7) << "towards the wall";
  EXPECT_GT((test::rotation_of(after) - test::rotation_of(before)).norm(), 0.01) << "the head turns";
}

TEST(RoomWalk, StandsWhereItDoesNotGo) {
  const RoomWalk unit({.label = "", .speed_m_s = 0}, test::Random(3));
  EXPECT_EQ(unit.camera_at(0).position_m, unit.camera_at(0.5).position_m);
  EXPECT_EQ(unit.camera_at(0).quaternion_wxyz, unit.camera_at(0.5).quaternion_wxyz);
}

TEST(RoomWalk, ExposesRowsOverTheReadoutAndEachForLessThanAPixelOfMotion) {
  const test::Lens lens;
  const RoomWalk unit({.label = "", .distance_m = 1, .speed_m_s = 1.6, .exposure_s = 0.006, .readout_s = 0.024},
                      test::Random(3));
  const test::Shutter shutter = unit.shutter(lens);
  EXPECT_NEAR(shutter.row_time_s, 50e-6, 1e-12);
  EXPECT_EQ(shutter.exposure_s, 0.006);
  EXPECT_GE(shutter.sub_exposures, 0.006 * 1.6 * lens.fx_px);
}

// One landmark straight ahead of a camera that looks along +X from 2 m away.
TEST(LandmarksShown, AreWhollyInThePictureLargeEnoughAndFromTheFront) {
  const auto count = [](double distance_m, double beside_m, double yaw_rad) {
    test::Room room;
    room.landmarks = {{test::RoomSide::kHighX, beside_m, 1.4, {}}};
    const test::CameraPose ahead{{room.high_m[0] - distance_m, 0, 1.4}, {0.5, -0.5, 0.5, -0.5}};
    const Eigen::Quaterniond turned =
        Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
    return landmarks_shown(room, test::Lens{}, {ahead.position_m, {turned.w(), turned.x(), turned.y(), turned.z()}})
        .size();
  };
  EXPECT_EQ(count(2, 0, 0), 1U);
  // 720 px of focal length: 319 px to the border are 0.886 m, and the sheet reaches 0.095 m to its side.
  EXPECT_EQ(count(2, 0.77, 0), 1U);
  EXPECT_EQ(count(2, 0.82, 0), 0U) << "cut by the border";
  EXPECT_EQ(count(2, 0, std::numbers::pi), 0U) << "behind the camera";
  EXPECT_EQ(count(7.5, 0, 0), 1U);
  EXPECT_EQ(count(7.5, 2.9, 0), 0U) << "dots of 2.1 px, seen from aside";
  EXPECT_EQ(count(8.6, 0, 0), 0U) << "dots of 2.1 px";
}

}  // namespace
}  // namespace ninedot::bench
