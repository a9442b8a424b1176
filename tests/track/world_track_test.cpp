// Ways past landmarks that come into view one after the other, one of which was moved since the map was made.
#include "track/world_track.h"

#include <gtest/gtest.h>

#include "tests/world/room.h"

namespace ninedot {
namespace {

using test::kDeg;
using test::Random;

constexpr double kRate_hz = 35;
MonoTime instant(int frame) { return mono_from_ns(1'000'000'000 + std::llround(frame * 1e9 / kRate_hz)); }

/// A camera that accelerates as the filter takes it to by default, about an even walk.
class Walk {
 public:
  explicit Walk(Random& random) : random_(random) {
    T_.rotation = test::level_camera(random.uniform(-3, 3), random.uniform(-0.1, 0.1), 3 * kDeg * random.normal());
    T_.translation_m = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(0.8, 1.6)};
    velocity_m_s_ = {random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), 0};
    turning_rad_s_ = {0, random.uniform(-0.5, 0.5), 0};
  }
  const WorldFromCamera& now() const { return T_; }
  void step() {
    constexpr double kSteps = PoseFilter::kManoeuvre_s * kRate_hz;
    if (++frame_ % static_cast<int>(kSteps) == 1) {
      for (int i = 0; i < 3; ++i) {
        acceleration_m_s2_[i] = options_.acceleration_sigma_m_s2 * random_.normal();
        angular_rad_s2_[i] = options_.angular_acceleration_sigma_rad_s2 * random_.normal();
      }
      angular_rad_s2_ -= 2 * turning_rad_s_;
    }
    const double dt_s = 1 / kRate_hz;
    velocity_m_s_ += dt_s * acceleration_m_s2_;
    turning_rad_s_ += dt_s * angular_rad_s2_;
    T_.translation_m += dt_s * velocity_m_s_;
    T_.rotation *= exp_so3(dt_s * turning_rad_s_);
  }

 private:
  Random& random_;
  PoseFilterOptions options_;
  WorldFromCamera T_;
  Eigen::Vector3d velocity_m_s_, turning_rad_s_, acceleration_m_s2_, angular_rad_s2_;
  int frame_ = 0;
};

/// What is in view for how long.
struct Stretch {
  int frames = 0;
  std::vector<std::size_t> landmarks;
};

/// Of the frames that show all of a stretch.
struct Tally {
  int frames = 0, valid = 0, wrong = 0, named_rightly = 0;
};

struct Outcome {
  std::vector<Tally> stretches;
  int wrongly_named = 0;  ///< at the end [1]
};

/// One way past the stretches' landmarks, `moved` of which hangs `aside_m` beside its place.
void walk_past(std::uint64_t seed, const std::vector<Stretch>& stretches, std::optional<std::size_t> moved,
               double aside_m, bool coded, Outcome& outcome) {
  Random random(seed);
  std::size_t count = 0;
  for (const Stretch& stretch : stretches)
    for (const std::size_t i : stretch.landmarks) count = std::max(count, i + 1);
  // The way first, then the sheets in view of it.
  std::vector<WorldFromCamera> way;
  std::vector<WorldFromLandmark> places(count);
  std::vector<bool> hangs(count);
  Walk walk(random);
  for (const Stretch& stretch : stretches) {
    for (const std::size_t i : stretch.landmarks) {
      if (hangs[i]) continue;
      hangs[i] = true;
      const auto is_free = [&] {
        for (std::size_t k = 0; k < count; ++k)
          if (k != i && hangs[k] && (places[k].translation_m - places[i].translation_m).norm() < 0.4) return false;
        return true;
      };
      do {
        places[i] = test::sheet_at(walk.now(), {random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3)},
                                   random.uniform(1.5, 4), random.uniform(-50, 50) * kDeg);
      } while (!is_free());
    }
    for (int frame = 0; frame < stretch.frames; ++frame) {
      way.push_back(walk.now());
      walk.step();
    }
  }
  std::vector<MappedLandmark> mapped;
  std::vector<PlacedLandmark> placed;
  for (std::size_t i = 0; i < count; ++i) {
    mapped.push_back({static_cast<std::uint16_t>(i + 1), "", places[i]});
    placed.push_back({.T_world_landmark = places[i], .is_black_and_white = !coded});
  }
  const LandmarkMap map(mapped);
  WorldSolver solver(placed, {});
  WorldTrack track(PoseFilterOptions{});
  outcome.stretches.resize(stretches.size());
  int frame = 0;
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    Tally& tally = outcome.stretches[s];
    for (int f = 0; f < stretches[s].frames; ++f, ++frame) {
      const WorldFromCamera& truth = way[static_cast<std::size_t>(frame)];
      std::vector<SightedLandmark> seen;
      for (const std::size_t i : stretches[s].landmarks) {
        const WorldFromLandmark hung =
            moved == i ? test::moved_sheet(places[i], aside_m, 40 * kDeg * aside_m) : places[i];
        const Eigen::Vector3d to_camera_m = hung.inverse() * truth.translation_m;
        const Eigen::Vector3d p9_m = truth.inverse() * hung.translation_m;
        if (p9_m.z() < 0.6 * p9_m.norm() || to_camera_m.y() < 0.3 * to_camera_m.norm()) continue;
        seen.push_back(test::sighting_of(random, truth, hung));
        if (coded) seen.back().coded = i;
        seen.back().others_odds = coded ? 1e-5 : 0;
      }
      const WorldPose pose = track.place(instant(frame), seen, map, solver);
      if (seen.size() < stretches[s].landmarks.size()) continue;  // the way has led past one
      ++tally.frames;
      tally.valid += pose.is_valid() ? 1 : 0;
      tally.wrong += pose.is_valid() && test::nees(pose, truth) > 60 ? 1 : 0;
      if (moved && pose.is_valid())
        for (const SightingVerdict& verdict : pose.sightings)
          tally.named_rightly += verdict.use == SightingUse::kRejected && verdict.landmark == *moved ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < count; ++i) outcome.wrongly_named += solver.moved().is_moved(i) && moved != i ? 1 : 0;
}

const std::vector<Stretch> kOneAfterTheOther{{20, {0, 1}}, {0, {}},         {14, {2}},
                                             {14, {2, 3}}, {14, {2, 3, 4}}, {14, {3, 4}}};
enum StretchOf : std::size_t { kBefore, kBlind, kAlone, kWithOne, kWithTwo, kAfter };

/// Twenty ways for each of some times without any landmark, after which landmark 2 comes into view alone.
Outcome many_ways(std::optional<std::size_t> moved, bool coded) {
  Outcome outcome;
  for (const int blind : {0, 7, 14, 28, 50}) {
    std::vector<Stretch> stretches = kOneAfterTheOther;
    stretches[kBlind].frames = blind;
    for (std::uint64_t seed = 2001; seed <= 2020; ++seed) walk_past(seed, stretches, moved, 0.15, coded, outcome);
  }
  return outcome;
}

class WorldTrackOf : public ::testing::TestWithParam<bool> {
 public:
  static bool coded() { return GetParam(); }
};

TEST_P(WorldTrackOf, SheetsInTheirPlacesDoubtsNone) {
  const Outcome outcome = many_ways(std::nullopt, coded());
  for (const std::size_t stretch : {kWithOne, kWithTwo, kAfter}) {
    const Tally& tally = outcome.stretches[stretch];
    EXPECT_GE(tally.valid, (coded() ? 0.99 : 0.9) * tally.frames) << stretch;  // the latter may look like others
    EXPECT_EQ(tally.wrong, 0) << stretch;
  }
  const Tally& alone = outcome.stretches[kAlone];
  EXPECT_GE(alone.valid, (coded() ? 0.97 : 0.7) * alone.frames);  // the latter need a track
  EXPECT_LE(alone.wrong, 0.01 * alone.frames);
  EXPECT_EQ(outcome.wrongly_named, 0);
}

/// The track goes where the moved one takes it: that must not make the others wrong which come into view beside it.
TEST_P(WorldTrackOf, OneThatWasMovedAndIsSeenFirstDoesNotOutvoteThoseThatComeAfterIt) {
  const Outcome outcome = many_ways(2, coded());
  const Tally& with_one = outcome.stretches[kWithOne];
  EXPECT_LE(with_one.wrong, 0.01 * with_one.frames);
  EXPECT_GE(with_one.valid, 0.25 * with_one.frames) << "what was known before decides where it can";
  const Tally& with_two = outcome.stretches[kWithTwo];
  EXPECT_LE(with_two.wrong, 0.005 * with_two.frames);
  EXPECT_GE(with_two.valid, 0.9 * with_two.frames);
  EXPECT_GE(with_two.named_rightly, 0.95 * (with_two.valid - with_two.wrong));
  const Tally& after = outcome.stretches[kAfter];
  EXPECT_LE(after.wrong, 0.005 * after.frames);
  EXPECT_GE(after.valid, (coded() ? 0.98 : 0.85) * after.frames);
  EXPECT_LE(outcome.wrongly_named, 2);  // of 200
}

INSTANTIATE_TEST_SUITE_P(, WorldTrackOf, ::testing::Values(true, false),
                         [](const auto& test) { return test.param ? "Coded" : "BlackAndWhite"; });

/// One that contradicts the track does not become true by the track's growing old.
TEST(WorldTrack, OneAloneThatContradictsItIsNoAnswer) {
  Outcome outcome;
  for (std::uint64_t seed = 2101; seed <= 2140; ++seed)
    walk_past(seed, {{20, {0, 1}}, {25, {2}}}, 2, 0.3, true, outcome);
  EXPECT_GE(outcome.stretches[0].valid, 0.99 * outcome.stretches[0].frames);
  EXPECT_LE(outcome.stretches[1].valid, 0.05 * outcome.stretches[1].frames);
}

/// Two contradict each other, and then one of them is seen alone: which one nobody knows, until a third is seen.
TEST(WorldTrack, OneOfTwoThatContradictedEachOtherIsNoAnswerAlone) {
  Outcome outcome;
  for (std::uint64_t seed = 2201; seed <= 2240; ++seed)
    walk_past(seed, {{10, {0, 2}}, {10, {2}}, {10, {0}}, {10, {0, 1}}, {5, {0}}, {38, {}}, {5, {0}}}, 2, 0.15, true,
              outcome);
  const auto valid_share = [&](std::size_t stretch) {
    return static_cast<double>(outcome.stretches[stretch].valid) / outcome.stretches[stretch].frames;
  };
  EXPECT_LE(valid_share(0), 0.02);
  EXPECT_LE(valid_share(1), 0.02);
  EXPECT_LE(valid_share(2), 0.02);
  EXPECT_GE(valid_share(3), 0.98);
  EXPECT_GE(valid_share(4), 0.95) << "by the track of two that agree";
  EXPECT_GE(valid_share(6), 0.9) << "it agreed for long enough";
  int wrong = 0;
  for (const Tally& tally : outcome.stretches) wrong += tally.wrong;
  EXPECT_LE(wrong, 10);
}

/// One that is far away agrees with whatever is near, wherever that hangs: it is no second witness.
TEST(WorldTrack, AMovedOneBesideOneThatKnowsLittleIsNoWitnessAgainstIt) {
  Random random(2301);
  constexpr int kTrials = 40, kFar = 10, kNear = 20;
  int valid = 0, wrong = 0, valid_with_third = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const test::Room room = test::random_room(random, {.landmarks = 3, .nearest_m = 1.5, .farthest_m = 2.5});
    std::vector<MappedLandmark> mapped;
    for (std::uint16_t id = 1; id <= 3; ++id) mapped.push_back({id, "", room.map[id - 1U].T_world_landmark});
    const LandmarkMap map(mapped);
    WorldSolver solver(room.map, {});
    WorldTrack track(PoseFilterOptions{});
    const auto look = [&](int frame, std::size_t count, double certainty) {
      std::vector<SightedLandmark> seen;
      for (std::size_t i = 0; i < count; ++i) {
        const WorldFromLandmark& place = room.map[i].T_world_landmark;
        WorldFromLandmark hung = place;
        if (i == 0) hung.translation_m -= 0.2 * place.rotation.col(1);  // the wall is farther than the map has it
        seen.push_back(test::sighting_of(random, room.T_world_camera, hung));
        seen.back().coded = i;
        seen.back().others_odds = 1e-5;
        if (i > 0)
          for (DotSighting& dot : seen.back().sighting.dots) dot.information *= certainty;
      }
      return track.place(instant(frame), seen, map, solver);
    };
    for (int frame = 0; frame < kFar; ++frame) static_cast<void>(look(frame, 2, 1e-5));
    for (int frame = kFar; frame < kFar + kNear; ++frame) {
      const WorldPose pose = look(frame, 2, 1);
      valid += pose.is_valid() ? 1 : 0;
      wrong += pose.is_valid() && test::nees(pose, room.T_world_camera) > 60 ? 1 : 0;
    }
    valid_with_third += look(kFar + kNear, 3, 1).is_valid() ? 1 : 0;
  }
  EXPECT_LE(wrong, 0.02 * kTrials * kNear) << "of " << valid << " valid ones";
  EXPECT_GE(valid_with_third, 0.8 * kTrials);
}

/// A sheet does not move while it is looked at: it was the camera that was knocked aside.
TEST(WorldTrack, BeginsAnewAtOnceWhereTheOneThatItStandsOnIsElsewhere) {
  Random random(33);
  int valid = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const test::Room room = test::random_room(random, {.landmarks = 1, .nearest_m = 1, .farthest_m = 2.5});
    const LandmarkMap map({{1, "", room.map[0].T_world_landmark}});
    WorldSolver solver(room.map, {});
    WorldTrack track(PoseFilterOptions{});
    WorldFromCamera T_world_camera = room.T_world_camera;
    const auto look = [&](int frame) {
      std::vector<SightedLandmark> seen{test::sighting_of(random, T_world_camera, room.map[0].T_world_landmark)};
      seen[0].coded = 0;
      return track.place(instant(frame), seen, map, solver).is_valid();
    };
    for (int frame = 0; frame < 10; ++frame) static_cast<void>(look(frame));
    T_world_camera.translation_m.z() += 0.3;
    for (int frame = 10; frame < 10 + PoseFilter::kMaxGated; ++frame) static_cast<void>(look(frame));
    for (int frame = 15; frame < 20; ++frame) valid += look(frame) ? 1 : 0;
  }
  EXPECT_GE(valid, 90);
}

}  // namespace
}  // namespace ninedot
