#include "world/prepared_map.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/random.h"

namespace ninedot {
namespace {

std::vector<PlacedLandmark> scattered(int landmarks) {
  test::Random random(41);
  std::vector<PlacedLandmark> map;
  for (int i = 0; i < landmarks; ++i)
    map.push_back({.T_world_landmark = place_upright(
                       {random.uniform(0, 5), random.uniform(0, 40), random.uniform(1, 2)}, random.uniform(-3, 3)),
                   .has_place = i % 10 != 0,
                   .is_black_and_white = i % 3 != 0});
  return map;
}

bool is_anonymous(const PlacedLandmark& landmark) { return landmark.has_place && landmark.is_black_and_white; }

TEST(PreparedMap, FindsWhatHangsNearAPointAndSaysWhenThereIsNoRoom) {
  const auto all = scattered(300);
  const PreparedMap map(all);
  test::Random random(42);
  NearbyLandmarks nearby;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d point_m(random.uniform(-1, 6), random.uniform(-1, 41), random.uniform(1, 2));
    const double radius_m = random.uniform(0.1, 2.5);
    std::vector<std::uint16_t> expected;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (is_anonymous(all[i]) && (all[i].T_world_landmark.translation_m - point_m).norm() <= radius_m)
        expected.push_back(static_cast<std::uint16_t>(i));
    ASSERT_EQ(map.find_nearby(point_m, radius_m, nearby), expected.size() <= NearbyLandmarks::capacity());
    if (expected.size() > NearbyLandmarks::capacity()) continue;
    std::ranges::sort(nearby);
    EXPECT_TRUE(std::ranges::equal(nearby, expected));
  }
}

TEST(PreparedMap, HasAllPairsThatOnePictureCanHoldByTheirDistance) {
  const auto all = scattered(200);
  const PreparedMap map(all);
  std::size_t expected = 0, within = 0;
  for (std::size_t a = 0; a < all.size(); ++a) {
    for (std::size_t b = a + 1; b < all.size(); ++b) {
      if (!is_anonymous(all[a]) || !is_anonymous(all[b])) continue;
      const double distance_m = (all[a].T_world_landmark.translation_m - all[b].T_world_landmark.translation_m).norm();
      expected += distance_m <= PreparedMap::kFarthestPair_m ? 1U : 0U;
      within += distance_m >= 3 && distance_m <= 3.1 ? 1U : 0U;
    }
  }
  EXPECT_EQ(map.pairs().size(), expected);
  EXPECT_EQ(map.pairs_at(3, 3.1).size(), within);
  EXPECT_TRUE(std::ranges::is_sorted(map.pairs(), {}, &LandmarkPair::distance_m));
}

TEST(PreparedMap, TakesTheMapsLandmarksInTheirOrder) {
  const LandmarkMap map({{7, "", place_upright({7, 0, 0}, 0)}, {2, "KRGBKKRB", place_upright({2, 0, 0}, 0)}});
  const auto placed = placed_landmarks(map);
  ASSERT_EQ(placed.size(), 2U);
  EXPECT_FALSE(placed[0].is_black_and_white);
  EXPECT_TRUE(placed[1].is_black_and_white);
  EXPECT_EQ(placed[1].T_world_landmark.translation_m.x(), 7);
}

}  // namespace
}  // namespace ninedot
