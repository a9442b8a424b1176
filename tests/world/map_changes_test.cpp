#include "world/map_changes.h"

#include <gtest/gtest.h>

#include <vector>

#include "world/moved_landmarks.h"

namespace ninedot {
namespace {

MappedLandmark landmark(std::uint16_t id, const char* code, double x_m) {
  return {id, code, place_upright({x_m, 0, 1}, 0.5)};
}

LandmarkMap hall() { return LandmarkMap({landmark(1, "", 0), landmark(4, "KRGBKKRB", 2), landmark(9, "RRGKBGKB", 4)}); }

TEST(MapChanges, AreNoneBetweenEqualMaps) { EXPECT_EQ(map_changes(hall(), hall()), MapChanges{}); }

TEST(MapChanges, CountsEachLandmarkOnce) {
  MappedLandmark turned = landmark(1, "", 0);
  turned.T_world_landmark = place_upright({0, 0, 1}, 0.6);
  MappedLandmark surer = landmark(9, "RRGKBGKB", 4);
  surer.covariance(0, 0) = 1e-6;
  const LandmarkMap now({turned, surer, landmark(2, "", 7), landmark(3, "", 8), landmark(5, "", 9)});
  EXPECT_EQ(map_changes(hall(), now), (MapChanges{.added = 3, .removed = 1, .moved = 1, .described = 1}));
  EXPECT_EQ(map_changes(now, hall()), (MapChanges{.added = 1, .removed = 3, .moved = 1, .described = 1}));
}

TEST(MapChanges, APlaceThatBecomesUnknownIsAMove) {
  const LandmarkMap before = hall();
  std::vector<MappedLandmark> now(before.landmarks().begin(), before.landmarks().end());
  now[2].has_place = false;
  EXPECT_EQ(map_changes(before, LandmarkMap(now)).moved, 1U);
}

TEST(MapChanges, ASheetIsTheSameByIdAndCode) {
  const LandmarkMap map = hall();
  EXPECT_EQ(index_of_sheet(map, landmark(9, "RRGKBGKB", 77)), 2U);
  EXPECT_EQ(index_of_sheet(map, landmark(9, "KRGBKKRB", 4)), std::nullopt);
  EXPECT_EQ(index_of_sheet(map, landmark(8, "RRGKBGKB", 4)), std::nullopt);
}

TEST(MapChanges, APlaceIsUnchangedToTheLastBitOnly) {
  const MappedLandmark before = landmark(1, "", 0.1);
  EXPECT_TRUE(is_place_unchanged(before, landmark(1, "", 0.1)));
  EXPECT_FALSE(is_place_unchanged(before, landmark(1, "", 0.1 + 1e-16)));
  MappedLandmark surer = before;
  surer.covariance(3, 3) = 1e-9;
  EXPECT_FALSE(is_place_unchanged(before, surer)) << "it weighs another amount";
}

TEST(MovedLandmarks, WhatIsKnownOfOneGoesOverToAnotherMap) {
  MovedLandmarks before(2, 3), now(4, 3);
  before.disagrees(1, 500);
  before.agrees(1);
  now.carry_over(before, 1, 2);
  EXPECT_TRUE(now.is_moved(2));
  now.agrees(2);
  EXPECT_TRUE(now.is_moved(2));
  now.agrees(2);
  EXPECT_FALSE(now.is_moved(2)) << "one of the three frames it had agreed before";
}

}  // namespace
}  // namespace ninedot
