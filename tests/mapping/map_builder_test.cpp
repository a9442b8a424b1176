#include "mapping/map_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "hall.h"
#include "mapping/place_vote.h"

namespace ninedot {
namespace {

using test::Hall;
using test::HallOptions;
using test::MapScore;

/// The first corridor and its ends.
HallOptions small_hall(std::uint64_t seed = 1) {
  HallOptions options;
  options.landmarks = 24;
  options.frames = 250;
  options.seed = seed;
  return options;
}

BuiltMap map_of(const Hall& hall, const LandmarkMap& known) {
  MapBuilderOptions options;
  options.exact = {1};
  return build_map(hall.frames, known, options);
}
BuiltMap map_of(const Hall& hall) { return map_of(hall, hall.known(1)); }

/// Without the pictures in which `is_bad`.
template <typename Bad>
void drop_frames(Hall& hall, const Bad& is_bad) {
  std::erase_if(hall.frames, is_bad);
}

bool shows(const RecordedSightings& frame, std::uint16_t id) {
  return std::ranges::any_of(frame.list, [&](const LandmarkSighting& seen) { return seen.id == id; });
}

TEST(MapBuilder, IsExactWithoutNoise) {
  HallOptions options = small_hall();
  options.noise = 0;
  const Hall hall = test::make_hall(options);
  const BuiltMap map = map_of(hall);
  const MapScore score = test::score(map, hall.truth, 1);
  EXPECT_EQ(score.placed, 23U);
  EXPECT_LT(score.worst_m, 1e-7);
  EXPECT_TRUE(map.disagreeing.empty());
  EXPECT_EQ(map.variance_factor, 1);
}

TEST(MapBuilder, MakesErrorsAsLargeAsItSays) {
  double squares = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    const Hall hall = test::make_hall(small_hall(seed));
    const BuiltMap map = map_of(hall);
    const MapScore score = test::score(map, hall.truth, 1);
    EXPECT_EQ(score.placed, 23U) << seed;
    EXPECT_TRUE(map.disagreeing.empty()) << seed;
    EXPECT_LT(score.axes, 2) << seed;
    squares += score.whole * score.whole / 5;
  }
  // 5 x 23 x 6 freedoms: the root of their mean is within 12 % of 1 in 999 of 1000 cases, were they independent.
  EXPECT_NEAR(std::sqrt(squares), 1, 0.15);
}

/// Rows that a rolling shutter took at other times: 4 px at 420 px focal length, beside dots that are certain to 0.05.
TEST(MapBuilder, RegardsThatTheCameraTurnedBetweenItsRows) {
  double squares = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    HallOptions options = small_hall(seed);
    options.turn_sigma_rad = 0.01;
    const Hall hall = test::make_hall(options);
    const BuiltMap map = map_of(hall);
    const MapScore score = test::score(map, hall.truth, 1);
    EXPECT_EQ(score.placed, 23U) << seed;
    EXPECT_LT(map.disagreeing.size(), 3U) << seed;
    EXPECT_LT(map.variance_factor, 1.1) << seed;
    squares += score.whole * score.whole / 3;
  }
  EXPECT_NEAR(std::sqrt(squares), 1, 0.2);
}

TEST(MapBuilder, MakesTheSameMapOfTheSameSightingsToTheLastBit) {
  HallOptions options = small_hall();
  options.turn_sigma_rad = 0.01;
  const Hall hall = test::make_hall(options);
  const BuiltMap map = map_of(hall);
  for (int again = 0; again < 4; ++again) {
    const BuiltMap other = map_of(hall);
    ASSERT_EQ(map.placed.size(), other.placed.size());
    for (std::size_t i = 0; i < map.placed.size(); ++i) {
      EXPECT_EQ(map.placed[i].T_world_landmark.translation_m, other.placed[i].T_world_landmark.translation_m);
      EXPECT_EQ(map.placed[i].covariance, other.placed[i].covariance);
    }
  }
}

TEST(MapBuilder, DoesNotMindMirrorImages) {
  HallOptions options = small_hall();
  options.mirrored = 1;
  const Hall hall = test::make_hall(options);
  const MapScore score = test::score(map_of(hall), hall.truth, 1);
  EXPECT_EQ(score.placed, 23U);
  EXPECT_LT(score.worst_m, 0.02);
}

TEST(MapBuilder, LeavesOutSightingsThatBearAnotherLandmarksId) {
  HallOptions options = small_hall();
  const Hall right = test::make_hall(options);
  options.wrong_identities = 0.03;
  const Hall hall = test::make_hall(options);
  const BuiltMap map = map_of(hall);
  const MapScore score = test::score(map, hall.truth, 1);
  EXPECT_EQ(score.placed, 23U);
  EXPECT_LT(score.whole, 1.5);
  EXPECT_GT(map.disagreeing.size(), 10U);
  std::size_t named = 0;
  for (const DisagreeingSighting& sighting : map.disagreeing) {
    const auto frame = std::ranges::find(hall.frames, sighting.frame, &RecordedSightings::frame);
    EXPECT_GT(sighting.chi2_over_limit, 1);
    // In a picture of two landmarks nobody can tell which one is wrong.
    std::set<std::uint16_t> true_ids, ids;
    for (const LandmarkSighting& seen : right.frames[sighting.frame].list) true_ids.insert(seen.id);
    for (const LandmarkSighting& seen : frame->list) ids.insert(seen.id);
    if (true_ids != ids || ids.size() < frame->list.size()) ++named;
  }
  EXPECT_GE(named, map.disagreeing.size() - 1) << "whom it names is, but for one, in a picture with a wrong identity";
}

TEST(MapBuilder, NamesThePicturesInWhichASheetHungElsewhere) {
  HallOptions options = small_hall();
  options.moved_id = 7;
  options.moved_share = 0.6;  // most of the first corridor's pictures come before and after
  const Hall hall = test::make_hall(options);
  const BuiltMap map = map_of(hall);
  ASSERT_GT(map.disagreeing.size(), 3U);
  std::size_t of_it = 0;
  for (const DisagreeingSighting& sighting : map.disagreeing) of_it += sighting.id == 7 ? 1 : 0;
  EXPECT_GE(of_it + 2, map.disagreeing.size());
  std::set<bool> late;
  for (const DisagreeingSighting& sighting : map.disagreeing)
    if (sighting.id == 7) late.insert(sighting.frame >= 100);
  EXPECT_EQ(late.size(), 1U) << "all before or all after the move";
}

TEST(MapBuilder, SaysWhichLandmarksNoPictureJoins) {
  Hall hall = test::make_hall(small_hall());
  for (RecordedSightings& frame : hall.frames)
    if (shows(frame, 5)) std::erase_if(frame.list, [](const LandmarkSighting& seen) { return seen.id != 5; });
  // 20 and 21 are seen together, but with nobody else.
  for (RecordedSightings& frame : hall.frames)
    if (shows(frame, 20) || shows(frame, 21))
      std::erase_if(frame.list, [](const LandmarkSighting& seen) { return seen.id != 20 && seen.id != 21; });
  const BuiltMap map = map_of(hall);
  EXPECT_EQ(map.unseen, std::vector<std::uint16_t>{5});
  ASSERT_GE(map.islands.size(), 1U);
  EXPECT_TRUE(std::ranges::count(map.islands, (std::vector<std::uint16_t>{20, 21})) == 1);
  EXPECT_FALSE(std::ranges::any_of(map.placed, [](const MappedLandmark& placed) { return placed.id == 5; }));
}

TEST(MapBuilder, IsNotJoinedByASinglePicture) {
  const Hall all = test::make_hall(small_hall());
  for (const std::size_t pictures : {1U, 2U}) {
    Hall hall = all;
    std::size_t kept = 0;
    drop_frames(hall, [&](const RecordedSightings& frame) { return shows(frame, 5) && ++kept > pictures; });
    const BuiltMap map = map_of(hall);
    const bool is_placed = std::ranges::any_of(map.placed, [](const MappedLandmark& placed) { return placed.id == 5; });
    EXPECT_EQ(is_placed, pictures >= 2);
  }
}

TEST(MapBuilder, EnlargesItsSigmasWhereThePicturesAreWorseThanTheySay) {
  HallOptions options = small_hall();
  options.noise = 3;
  const Hall hall = test::make_hall(options);
  const BuiltMap map = map_of(hall);
  EXPECT_NEAR(map.variance_factor, 9, 1);
  EXPECT_NEAR(test::score(map, hall.truth, 1).whole, 1, 0.3);
}

TEST(MapBuilder, TakesSurveyedPlacesForWhatTheyAre) {
  const Hall hall = test::make_hall(small_hall());
  const LandmarkMap known = hall.known(1);
  std::vector<MappedLandmark> landmarks(known.landmarks().begin(), known.landmarks().end());
  MappedLandmark& surveyed = landmarks[22];
  surveyed = hall.truth[22];
  surveyed.covariance = 1e-8 * PlaceCovariance::Identity();
  const BuiltMap map = map_of(hall, LandmarkMap(landmarks));
  EXPECT_LT(test::score(map, hall.truth, 1).rms_m, test::score(map_of(hall), hall.truth, 1).rms_m);
  EXPECT_LT(map.placed[22].covariance(0, 0), 1.01e-8);
  EXPECT_TRUE(map.disagreeing_surveys.empty());

  surveyed.T_world_landmark.translation_m.x() += 0.5;
  const BuiltMap contradicted = map_of(hall, LandmarkMap(landmarks));
  EXPECT_EQ(contradicted.disagreeing_surveys, std::vector<std::uint16_t>{23});
  EXPECT_LT(test::score(contradicted, hall.truth, 1).worst_m, 0.02);
}

TEST(MapBuilder, KnowsWhichNeighboursAreTheLeastCertain) {
  Hall hall = test::make_hall(small_hall());
  const BuiltMap before = map_of(hall);
  // 9 and 11 hang side by side, and hardly a picture is left that shows 11 with anything.
  std::size_t kept = 0;
  drop_frames(hall, [&](const RecordedSightings& frame) { return shows(frame, 11) && ++kept > 3; });
  const BuiltMap map = map_of(hall);
  ASSERT_TRUE(before.weakest && map.weakest);
  EXPECT_TRUE(map.weakest->a == 11 || map.weakest->b == 11) << map.weakest->a << " " << map.weakest->b;
  EXPECT_GT(map.weakest->sigma_m, before.weakest->sigma_m);
}

}  // namespace
}  // namespace ninedot
