#include "track/lone_stand.h"

#include <gtest/gtest.h>

#include "tests/world/room.h"

namespace ninedot {
namespace {

using test::kDeg;
using test::Random;

WorldFromCamera somewhere(Random& random) {
  return {test::level_camera(random.uniform(-3, 3), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)),
          {random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0.5, 2)}};
}

PoseStep draw(Random& random, const PoseCovariance& covariance) {
  PoseStep normal;
  for (double& x : normal) x = random.normal();
  return covariance.llt().matrixL() * normal;
}

/// Position, turn and what both have to do with each other.
PoseCovariance some_covariance(Random& random) {
  PoseCovariance A;
  for (double& x : A.reshaped()) x = 1e-4 * random.normal();
  return A * A.transpose() + 1e-9 * PoseCovariance::Identity();
}

/// Where a camera seems to be by a sheet that is not where the map has it: everything turned and shifted as one.
WorldFromCamera moved_by_sheet(const WorldFromCamera& T_moved, const WorldFromCamera& T_world_camera) {
  return {T_moved.rotation * T_world_camera.rotation,
          T_moved.rotation * T_world_camera.translation_m + T_moved.translation_m};
}

/// A robot that goes on by one sheet alone, which was moved by half a metre, from a place that it knew.
TEST(LoneStand, WhatWasKnownBeforeGoesTheSameWayWithItsErrorWhereverTheSheetHangs) {
  Random random(31);
  constexpr int kTrials = 4000;
  double chi2 = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const WorldFromCamera then = somewhere(random), now = somewhere(random), moved = somewhere(random);
    const PoseCovariance covariance = some_covariance(random);
    const WorldPrior before{.T_world_camera = moved_by(then, draw(random, covariance)), .covariance = covariance};
    LoneStand stand;
    stand.note(7, &before, moved_by_sheet(moved, then), PoseCovariance::Zero());
    WorldPrior prior{.T_world_camera = moved_by_sheet(moved, now)}, without;
    stand.complete(prior, without);
    ASSERT_EQ(prior.stands_on, 7U);
    ASSERT_EQ(prior.without, &without);
    const PoseStep error = step_between(without.T_world_camera, now);
    chi2 += error.dot(without.covariance.llt().solve(error)) / kTrials;
  }
  EXPECT_NEAR(chi2, 6, 0.3);  // six freedoms; its own scatter is 0.055
}

TEST(LoneStand, SaysNothingWhereSeveralAreSeenOrNothingWasKnown) {
  const WorldPrior before{.T_world_camera = {}, .covariance = PoseCovariance::Identity()};
  LoneStand stand;
  WorldPrior prior, without;
  stand.complete(prior, without);
  EXPECT_FALSE(prior.stands_on);
  stand.note(3, nullptr, {}, PoseCovariance::Identity());
  stand.complete(prior, without);
  EXPECT_EQ(prior.stands_on, 3U);
  EXPECT_EQ(prior.without, nullptr) << "the track began with it";
  stand.note(std::nullopt, &before, {}, PoseCovariance::Identity());
  stand.complete(prior, without);
  EXPECT_FALSE(prior.stands_on);
  EXPECT_EQ(prior.without, nullptr);
}

/// Its own track is no knowledge of before.
TEST(LoneStand, StaysWhatItWasAsLongAsTheSameOneIsSeen) {
  WorldPrior before{.T_world_camera = {}, .covariance = PoseCovariance::Identity()};
  LoneStand stand;
  stand.note(3, &before, {}, PoseCovariance::Zero());
  before.covariance *= 1e-6;
  stand.note(3, &before, {}, PoseCovariance::Zero());
  WorldPrior prior, without;
  stand.complete(prior, without);
  ASSERT_NE(prior.without, nullptr);
  EXPECT_GE(without.covariance(0, 0), 1);
  stand.note(4, &before, {}, PoseCovariance::Zero());
  prior.without = nullptr;
  stand.complete(prior, without);
  ASSERT_NE(prior.without, nullptr);
  EXPECT_LT(without.covariance(0, 0), 1e-3);
}

}  // namespace
}  // namespace ninedot
