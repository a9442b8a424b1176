#include "world/world_solver.h"

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"
#include "tests/world/room.h"

namespace ninedot {
namespace {

using test::kDeg;
using test::Random;
using test::Room;

/// The bound: the inverse of all rays' information at the truth.
PoseCovariance bound(const Room& room, std::span<const SightedLandmark> seen) {
  SightingFit sum;
  for (std::size_t i = 0; i < seen.size(); ++i)
    sum += fit_of_sighting(seen[i].sighting, room.map[i].T_world_landmark, room.T_world_camera, {});
  return sum.normal.inverse();
}

TEST(WorldSolver, ReachesTheCramerRaoBoundAndSaysHowWell) {
  Random random(1);
  constexpr int kTrials = 3000;
  double sum_nees = 0, against_bound = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Room room = test::random_room(random, {.landmarks = 2 + trial % 7});
    const auto seen = test::sightings_of(random, room);
    WorldSolver solver(room.map, {});
    const WorldPose pose = solver.solve(seen);
    ASSERT_TRUE(pose.is_valid()) << trial;
    ASSERT_EQ(pose.count(SightingUse::kUsed), seen.size()) << trial;
    sum_nees += test::nees(pose, room.T_world_camera);
    const PoseStep error = step_between(pose.T_world_camera, room.T_world_camera);
    against_bound += error.dot(bound(room, seen).llt().solve(error));
  }
  // Means of 3000 chi^2 of six freedoms: 6 +- 0.063. Ten per cent of standard deviation would make 7.3 of it.
  EXPECT_NEAR(sum_nees / kTrials, 6, 4 * 0.063);
  EXPECT_NEAR(against_bound / kTrials, 6, 4 * 0.063);
}

TEST(WorldSolver, CountsTheUncertaintyOfTheLandmarksPlaces) {
  Random random(2);
  constexpr int kTrials = 2000;
  PoseStep sigma;
  sigma << 0.004, 0.004, 0.004, 0.3 * kDeg, 0.3 * kDeg, 0.3 * kDeg;
  double sum_nees = 0, sum_claimed_exact = 0;
  int valid = 0, used = 0, seen_all = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Room room = test::random_room(random, {.landmarks = 2 + trial % 4});
    const auto seen = test::sightings_of(random, room);
    for (PlacedLandmark& landmark : room.map) {
      PoseStep error;
      for (double& e : error) e = random.normal();
      error = sigma.cwiseProduct(error);
      landmark.T_world_landmark.translation_m += error.head<3>();
      landmark.T_world_landmark.rotation = exp_so3(error.tail<3>()) * landmark.T_world_landmark.rotation;
      landmark.covariance = sigma.cwiseAbs2().asDiagonal();
    }
    const WorldPose pose = WorldSolver(room.map, {}).solve(seen);
    used += static_cast<int>(pose.count(SightingUse::kUsed));
    seen_all += static_cast<int>(seen.size());
    if (!pose.is_valid()) continue;
    ++valid;
    sum_nees += test::nees(pose, room.T_world_camera);
    sum_claimed_exact +=
        step_between(pose.T_world_camera, room.T_world_camera)
            .dot(bound(room, seen).llt().solve(step_between(pose.T_world_camera, room.T_world_camera)));
  }
  EXPECT_GE(valid, kTrials * 999 / 1000);
  EXPECT_GE(used, seen_all * 0.999);
  // 6 +- 0.077, and the curvature of 0.3 degrees at 6 m; without the places it would claim a tenth of the error.
  EXPECT_NEAR(sum_nees / valid, 6, 5 * 0.077);
  EXPECT_GT(sum_claimed_exact / valid, 60);
}

bool is_nearer_to_mirror(const Room& room, const SightedLandmark& seen) {
  const CameraFromLandmark truth = room.T_world_camera.inverse() * room.map[0].T_world_landmark;
  const auto off_rad = [&](const CameraFromLandmark& T) {
    return log_so3(T.rotation.transpose() * truth.rotation).norm();
  };
  return off_rad(*seen.mirror) < off_rad(seen.sighting.T_camera_landmark);
}

TEST(WorldSolver, LeavesTheCrestsOfOneSmallLandmarkOpenAndASecondOneDecides) {
  Random random(3);
  int open = 0, wrong = 0, decided = 0;
  constexpr int kTrials = 1000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Room room =
        test::random_room(random, {.landmarks = 2, .nearest_m = 4, .farthest_m = 6, .most_tilt_rad = 15 * kDeg});
    const auto seen = test::sightings_of(random, room);
    WorldSolver solver(room.map, {});
    const WorldPose alone = solver.solve({seen.data(), 1});
    open += alone.verdict == WorldVerdict::kAmbiguous ? 1 : 0;
    if (alone.is_valid() && seen[0].mirror) wrong += is_nearer_to_mirror(room, seen[0]) ? 1 : 0;
    const WorldPose both = solver.solve(seen);
    decided += both.is_valid() && test::nees(both, room.T_world_camera) < 40 ? 1 : 0;
  }
  EXPECT_GT(open, kTrials / 2);
  EXPECT_LE(wrong, (kTrials - open) / 100 + 3);
  EXPECT_GE(decided, kTrials * 99 / 100);
}

TEST(WorldSolver, TakesTheCrestThatTheTrackSays) {
  Random random(4);
  int decided = 0, decided_by_doubt = 0, open = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Room room =
        test::random_room(random, {.landmarks = 1, .nearest_m = 3, .farthest_m = 4, .most_tilt_rad = 25 * kDeg});
    const auto seen = test::sightings_of(random, room);
    WorldSolver solver(room.map, {});
    if (solver.solve(seen).is_valid()) continue;
    ++open;
    WorldPrior prior{.T_world_camera = room.T_world_camera};
    prior.covariance.diagonal() << 4e-4, 4e-4, 4e-4, 1e-4, 1e-4, 1e-4;
    const WorldPose pose = solver.solve(seen, &prior);
    decided += pose.is_valid() && test::nees(pose, room.T_world_camera) < 60 ? 1 : 0;
    prior.ambiguity = 0.3;
    decided_by_doubt += solver.solve(seen, &prior).is_valid() ? 1 : 0;
  }
  EXPECT_GT(open, 30);
  EXPECT_GT(decided, open * 8 / 10);
  EXPECT_LT(decided_by_doubt, open * 2 / 10) << "a track that is in doubt itself decides by no more than its odds";
}

TEST(WorldSolver, AnswersWhatThePictureSaysAndNotThePrior) {
  Random random(5);
  const Room room = test::random_room(random, {.landmarks = 3});
  const auto seen = test::sightings_of(random, room);
  WorldSolver solver(room.map, {});
  WorldPrior prior{.T_world_camera = moved_by(room.T_world_camera, PoseStep::Constant(0.002))};
  prior.covariance = 1e-5 * PoseCovariance::Identity();
  const WorldPose without = solver.solve(seen), with = solver.solve(seen, &prior);
  EXPECT_TRUE(with.agrees_with_prior);
  EXPECT_EQ(step_between(with.T_world_camera, without.T_world_camera).norm(), 0);
  prior.T_world_camera.translation_m.x() += 1;
  EXPECT_FALSE(solver.solve(seen, &prior).agrees_with_prior);
  EXPECT_TRUE(solver.solve(seen, &prior).is_valid());  // three landmarks outvote a track
}

TEST(WorldSolver, TakesNoPartOfLandmarksWithoutAPlace) {
  Random random(6);
  Room room = test::random_room(random, {.landmarks = 3});
  const auto seen = test::sightings_of(random, room);
  room.map[1].has_place = false;
  room.map[1].T_world_landmark = {};
  WorldSolver solver(room.map, {});
  const WorldPose pose = solver.solve(seen);
  EXPECT_TRUE(pose.is_valid());
  EXPECT_EQ(pose.sightings[1].use, SightingUse::kNoPlace);
  EXPECT_EQ(pose.count(SightingUse::kUsed), 2U);
  EXPECT_LT(test::nees(pose, room.T_world_camera), 30);
  EXPECT_EQ(solver.solve({&seen[1], 1}).verdict, WorldVerdict::kNothingSeen);
  EXPECT_EQ(solver.solve({}).verdict, WorldVerdict::kNothingSeen);
}

TEST(WorldSolver, SaysThatTooFewDotsDetermineNothing) {
  Random random(7);
  const Room room = test::random_room(random, {.landmarks = 1});
  auto seen = test::sightings_of(random, room);
  for (std::size_t dot = 2; dot < kDotCount; ++dot) seen[0].sighting.dots[dot] = {};
  EXPECT_EQ(WorldSolver(room.map, {}).solve(seen).verdict, WorldVerdict::kUndetermined);
}

TEST(WorldSolver, AllocatesNothing) {
  Random random(8);
  const Room room = test::random_room(random, {.landmarks = 12});
  Room anonymous = test::random_room(random, {.landmarks = 6, .coded = false});
  auto seen = test::sightings_of(random, room);
  const auto unknown = test::sightings_of(random, anonymous);
  seen[3] = test::sighting_of(random, room.T_world_camera, test::moved_sheet(room.map[3].T_world_landmark));
  seen[3].coded = 3;
  WorldSolver solver(room.map, {}), finder(anonymous.map, {});
  const WorldPrior prior{.T_world_camera = anonymous.T_world_camera, .covariance = 1e-3 * PoseCovariance::Identity()};
  const test::AllocationGuard guard;
  const WorldPose a = solver.solve(seen), b = finder.solve(unknown), c = finder.solve(unknown, &prior);
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_EQ(guard.releases(), 0U);
  EXPECT_TRUE(a.is_valid() && b.is_valid() && c.is_valid());
}

/// How its cost is measured: valgrind --tool=callgrind --toggle-collect='*WorldSolver::solve*' on each of the two; the
/// difference over 800 is what a further landmark costs.
void solve_hundred_times(int landmarks) {
  Random random(9);
  const Room room = test::random_room(random, {.landmarks = landmarks});
  WorldSolver solver(room.map, {});
  for (int frame = 0; frame < 100; ++frame) {
    const WorldPose pose = solver.solve(test::sightings_of(random, room));
    ASSERT_EQ(pose.count(SightingUse::kUsed), room.map.size());
  }
}
TEST(WorldCost, OfFourLandmarks) { solve_hundred_times(4); }
TEST(WorldCost, OfTwelveLandmarks) { solve_hundred_times(12); }

}  // namespace
}  // namespace ninedot
