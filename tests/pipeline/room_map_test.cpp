// A map takes the place of another one while a localiser runs.
#include "pipeline/room_map.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include "pipeline/localiser.h"
#include "pipeline/room_localiser.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

const Eigen::Vector3d kNowhere_m(100, 0, 0);

/// On the wall y = 0; no two pairs are alike.
const Eigen::Vector3d kWall_m[] = {{-0.45, 0, 0.05}, {0, 0, -0.12}, {0.62, 0, 0.2}};

MappedLandmark hung(std::uint16_t id, const Eigen::Vector3d& position_m) {
  return {id, "", place_upright(position_m, 0)};
}

/// The three of the wall, ids 1 to 3, all moved by `by_m`.
std::vector<MappedLandmark> wall(const Eigen::Vector3d& by_m = Eigen::Vector3d::Zero()) {
  std::vector<MappedLandmark> landmarks;
  for (const Eigen::Vector3d& position_m : kWall_m)
    landmarks.push_back(hung(static_cast<std::uint16_t>(landmarks.size() + 1), position_m + by_m));
  return landmarks;
}

std::unique_ptr<RoomMap> room_map(std::vector<MappedLandmark> landmarks) {
  return std::make_unique<RoomMap>(LandmarkGeometry{}, LandmarkMap(std::move(landmarks)), 0.01);
}

class MapOfARunningLocaliser : public testing::Test {
 protected:
  MapOfARunningLocaliser() {
    test::Scene scene;
    scene.camera = test::look_at_landmark({.distance_m = 2.2, .tilt_rad = 0.4, .azimuth_rad = 0.2});
    scene.sheets.clear();
    for (const Eigen::Vector3d& position_m : kWall_m) {
      scene.sheets.push_back(test::nine_dot_sheet());
      scene.sheets.back().x_m = position_m.x(), scene.sheets.back().z_m = position_m.z();
    }
    set_noise(scene.sensor, 1.5);
    picture_ = test::render(scene, 1);
    camera_m_ = Eigen::Vector3d(scene.camera.position_m[0], scene.camera.position_m[1], scene.camera.position_m[2]);
  }

  /// The next frame, without a heap call.
  const Fix& look(FrameProcessor& unit) {
    Frame frame;
    frame.number = ++number_;
    frame.luma = picture_.view();
    frame.set_exposure(MonoTime(5s + number_ * 28ms));
    const test::AllocationGuard guard;
    const Fix& fix = unit.process(frame);
    EXPECT_EQ(guard.allocations(), 0U) << "frame " << number_;
    EXPECT_EQ(guard.releases(), 0U) << "frame " << number_;
    return fix;
  }

  /// In a room of the wall's landmarks, after so many frames that its track is settled.
  RoomLocaliser& room_that_runs() {
    room_ = std::make_unique<RoomLocaliser>(CameraModel{},
                                            LocaliserOptions{.map = LandmarkMap(wall()), .new_maps = &maps_});
    for (int i = 0; i < 12; ++i) look(*room_);
    return *room_;
  }

  static double speed_sigma_m_s(const Fix& fix) { return std::sqrt(fix.track->covariance.block<3, 3>(6, 6).trace()); }

  RoomMapHandoff maps_;
  test::Picture picture_;
  Eigen::Vector3d camera_m_;
  std::unique_ptr<RoomLocaliser> room_;
  std::uint64_t number_ = 0;
};

TEST_F(MapOfARunningLocaliser, SaysWhereTheCameraIsFromTheNextFrameOn) {
  RoomLocaliser& unit = room_that_runs();
  const Eigen::Vector3d by_m(1, -2, 0.5);
  maps_.put(room_map(wall(by_m)));
  const Fix& fix = look(unit);
  EXPECT_EQ(fix.reason, Reason::kNone) << "no frame is lost";
  EXPECT_TRUE(fix.tracked);
  ASSERT_TRUE(fix.world);
  EXPECT_EQ(fix.world->used.size(), 3U);
  EXPECT_LT((fix.world->T_world_camera.translation_m - camera_m_ - by_m).norm(), 0.02);
}

TEST_F(MapOfARunningLocaliser, BeginsTheTrackAnewWhereItsLandmarksHangElsewhere) {
  RoomLocaliser& unit = room_that_runs();
  const double settled_m_s = speed_sigma_m_s(look(unit));
  std::vector<MappedLandmark> one_moved = wall();
  one_moved[2].T_world_landmark.translation_m.x() += 1e-4;
  maps_.put(room_map(one_moved));
  const Fix& fix = look(unit);
  ASSERT_TRUE(fix.track);
  EXPECT_GT(speed_sigma_m_s(fix), 4 * settled_m_s) << "of its motion nothing is known yet";
  EXPECT_EQ(fix.track->gated_frames, 0);
}

TEST_F(MapOfARunningLocaliser, BeginsTheTrackAnewWhereOneOfItsLandmarksIsGone) {
  RoomLocaliser& unit = room_that_runs();
  const double settled_m_s = speed_sigma_m_s(look(unit));
  std::vector<MappedLandmark> two = wall();
  two.pop_back();
  maps_.put(room_map(two));
  const Fix& fix = look(unit);
  ASSERT_TRUE(fix.world);
  EXPECT_EQ(fix.world->used.size(), 2U);
  EXPECT_GT(speed_sigma_m_s(fix), 4 * settled_m_s);
}

TEST_F(MapOfARunningLocaliser, KeepsTheTrackWhereOnlyOthersHaveChanged) {
  RoomLocaliser& unit = room_that_runs();
  const double settled_m_s = speed_sigma_m_s(look(unit));
  std::vector<MappedLandmark> more = wall();
  more.push_back(hung(0, kNowhere_m));  // becomes the first of them
  maps_.put(room_map(more));
  EXPECT_LT(speed_sigma_m_s(look(unit)), 1.2 * settled_m_s);
  more.back() = hung(0, 2 * kNowhere_m);
  maps_.put(room_map(more));
  const Fix& fix = look(unit);
  EXPECT_LT(speed_sigma_m_s(fix), 1.2 * settled_m_s);
  EXPECT_EQ(fix.world->used.size(), 3U);
}

TEST_F(MapOfARunningLocaliser, MayHoldAThousandLandmarksAndBeFreedByAnother) {
  RoomLocaliser& unit = room_that_runs();
  std::vector<MappedLandmark> many = wall();
  for (std::uint16_t id = 4; id <= LandmarkMap::kCapacity; ++id)
    many.push_back(hung(id, kNowhere_m + id * Eigen::Vector3d(0, 5, 0)));
  for (int i = 0; i < 3; ++i) {
    maps_.put(room_map(many));
    EXPECT_EQ(look(unit).world->used.size(), 3U);
    maps_.put(room_map(wall()));
    EXPECT_EQ(look(unit).world->used.size(), 3U);
  }
}

/// Not believed alone, as before.
TEST_F(MapOfARunningLocaliser, DoesNotForgetWhichSheetsWereMoved) {
  std::vector<MappedLandmark> wrong = wall();
  wrong[1].T_world_landmark.translation_m.x() += 0.15;
  wrong.push_back(hung(4, kNowhere_m));
  RoomMap before({}, LandmarkMap(wrong), 0.01);
  std::vector<SightedLandmark> seen;
  RoomLocaliser& unit = room_that_runs();
  for (const LandmarkFix& fix : look(unit).landmarks)
    seen.push_back({.sighting = fix.sighting, .mirror = {}, .coded = std::size_t{fix.id} - 1U});
  ASSERT_TRUE(before.world.solve(seen).is_valid());
  ASSERT_TRUE(before.world.moved().is_moved(1));

  std::vector<MappedLandmark> fewer = wrong;
  fewer.erase(fewer.begin());
  RoomMap now({}, LandmarkMap(fewer), 0.01);
  EXPECT_TRUE(now.take_over(before));
  EXPECT_TRUE(now.world.moved().is_moved(0)) << "id 2 is the first one now";
  EXPECT_FALSE(now.world.moved().is_moved(1));

  RoomMap corrected({}, LandmarkMap(wall()), 0.01);
  EXPECT_TRUE(corrected.take_over(before));
  EXPECT_FALSE(corrected.world.moved().is_moved(1)) << "the map says now where it hangs";
}

TEST_F(MapOfARunningLocaliser, OfOneLandmarkMovesTheCameraWithIt) {
  Localiser unit(CameraModel{}, {.map = LandmarkMap({hung(7, Eigen::Vector3d::Zero())}), .new_maps = &maps_});
  for (int i = 0; i < 5; ++i) look(unit);
  const WorldFromCamera before = look(unit).main().T_world_camera;
  maps_.put(room_map({hung(8, {3, 2, 1})}));
  const Fix& fix = look(unit);
  EXPECT_EQ(fix.reason, Reason::kNone);
  EXPECT_EQ(fix.main().id, 8);
  EXPECT_LT((fix.main().T_world_camera.translation_m - before.translation_m - Eigen::Vector3d(3, 2, 1)).norm(), 0.01);
  ASSERT_TRUE(fix.track);
  EXPECT_LT((fix.track->motion.T_world_camera.translation_m - fix.main().T_world_camera.translation_m).norm(), 0.02);
}

}  // namespace
}  // namespace ninedot
