#include "track/row_time_belief.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "tests/support/random.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using test::Random;

constexpr int kRows = 480;
constexpr double kRolling_s = 33e-6;

RowTimeBelief belief_of(const std::optional<std::chrono::nanoseconds>& told) {
  return {told, kRows, RowTimeBelief::Untold::kIsOpen};
}

/// Pictures of a camera with this row time, by which it is known to `sigma_s`.
class Pictures {
 public:
  Pictures(double true_s, double sigma_s, std::uint64_t seed) : true_s_(true_s), sigma_s_(sigma_s), random_(seed) {}

  /// \return  whether one of them contradicted what was told
  bool show(RowTimeBelief& belief, int count) {
    bool is_contradicted = false;
    for (int i = 0; i < count; ++i) {
      const double off_s = true_s_ - belief.begin(Frame{}).mean_s + sigma_s_ * random_.normal();
      is_contradicted |= belief.learn({.error_s = off_s, .information_1_s2 = 1 / (sigma_s_ * sigma_s_)}) ==
                         RowTimeBelief::News::kContradicted;
    }
    belief.begin(Frame{});
    return is_contradicted;
  }

 private:
  double true_s_, sigma_s_;
  Random random_;
};

TEST(RowTimeBelief, LearnsWhatNobodyTold) {
  for (const double true_s : {0.0, kRolling_s, -kRolling_s}) {
    RowTimeBelief belief = belief_of(std::nullopt);
    EXPECT_EQ(belief.now().source, RowTimeSource::kOpen);
    EXPECT_EQ(belief.now().mean_s, 0);
    EXPECT_GT(belief.now().sigma_s, 25e-6);
    Pictures pictures(true_s, 4e-6, 1);
    pictures.show(belief, 4);
    EXPECT_NEAR(belief.now().mean_s, true_s, 4 * belief.now().sigma_s);
    pictures.show(belief, 30);
    EXPECT_EQ(belief.now().source, RowTimeSource::kSeen);
    EXPECT_NEAR(belief.now().mean_s, true_s, 3e-6);
    EXPECT_LT(belief.now().sigma_s, 1.7e-6);
  }
}

TEST(RowTimeBelief, ErrorsAreAsLargeAsItSays) {
  double squares = 0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    RowTimeBelief belief = belief_of(std::nullopt);
    Pictures(kRolling_s, 6e-6, 100 + static_cast<std::uint64_t>(trial)).show(belief, 12);
    squares += std::pow((belief.now().mean_s - kRolling_s) / belief.now().sigma_s, 2);
  }
  EXPECT_GT(std::sqrt(squares / kTrials), 0.5) << "not worth less than they are";
  EXPECT_LT(std::sqrt(squares / kTrials), 1.1);
}

TEST(RowTimeBelief, NeverClaimsMoreThanWhatAllPicturesShareAllows) {
  RowTimeBelief belief = belief_of(std::nullopt);
  Pictures(kRolling_s, 1e-9, 2).show(belief, 10000);
  EXPECT_NEAR(belief.now().sigma_s, 0.3e-3 / kRows, 1e-9);
}

TEST(RowTimeBelief, ToldItStaysWithThatForMonths) {
  RowTimeBelief belief = belief_of(33us);
  // A month at 35 Hz of a row time that is told 3 % wrong, and of pictures that say as much as any.
  EXPECT_FALSE(Pictures(34e-6, 3e-6, 3).show(belief, 1'000'000));
  EXPECT_EQ(belief.now().source, RowTimeSource::kTold);
  EXPECT_EQ(belief.now().mean_s, 33e-6);
}

TEST(RowTimeBelief, ToldWronglyItDoubtsAndThenGoesByThePictures) {
  for (const auto told : {0us, 20us, 45us}) {
    RowTimeBelief belief = belief_of(told);
    Pictures pictures(kRolling_s, 4e-6, 4);
    EXPECT_EQ(belief.now().sigma_s, 0);
    EXPECT_FALSE(pictures.show(belief, 1));
    bool is_contradicted = false;
    int doubted = 0;
    for (int i = 0; i < 30 && !is_contradicted; ++i) {
      is_contradicted = pictures.show(belief, 1);
      if (is_contradicted) continue;
      EXPECT_EQ(belief.now().mean_s, std::chrono::duration<double>(told).count());
      doubted += belief.now().sigma_s > 0;
    }
    EXPECT_TRUE(is_contradicted) << told.count();
    EXPECT_GT(doubted, 0) << told.count();
    EXPECT_EQ(belief.now().source, RowTimeSource::kContradicted);
    EXPECT_NEAR(belief.now().mean_s, kRolling_s, 4 * belief.now().sigma_s);
    EXPECT_FALSE(pictures.show(belief, 100)) << "once";
    EXPECT_NEAR(belief.now().mean_s, kRolling_s, 2e-6);
  }
}

/// A lone sheet that is bent shears as a rolling shutter does, in every picture of a camera that goes on and on.
TEST(RowTimeBelief, IsNotContradictedByWhatAWarpedSheetLooksLike) {
  RowTimeBelief belief = belief_of(0us);
  const auto shows = [&](double off_s) {
    return belief.learn({.error_s = off_s, .information_1_s2 = 1e12, .unexplained_s = 5e-6}) ==
           RowTimeBelief::News::kContradicted;
  };
  for (int i = 0; i < 1000; ++i) {
    belief.begin(Frame{});
    EXPECT_FALSE(shows(12e-6)) << i;
  }
  EXPECT_GT(belief.begin(Frame{}).sigma_s, 10e-6) << "but it is doubted";
  bool is_contradicted = false;
  for (int i = 0; i < 1000; ++i) belief.begin(Frame{}), is_contradicted |= shows(25e-6);
  EXPECT_TRUE(is_contradicted) << "what no sheet is warped by is";
}

TEST(RowTimeBelief, LearnsLittleFromSheetsWhoseSpeedIsNotKnown) {
  RowTimeBelief known = belief_of(std::nullopt), unknown = belief_of(std::nullopt);
  known.begin(Frame{}), unknown.begin(Frame{});
  known.learn({.error_s = kRolling_s, .information_1_s2 = 1e12});
  unknown.learn({.error_s = kRolling_s, .information_1_s2 = 1e12, .motion_share = 0.29});
  EXPECT_LT(known.begin(Frame{}).sigma_s, 12e-6);
  EXPECT_GT(unknown.begin(Frame{}).sigma_s, 1.3 * known.begin(Frame{}).sigma_s);
}

/// A camera that goes on gaining speed is slower in its track than it is, in all pictures alike.
TEST(RowTimeBelief, NoNumberOfPicturesAveragesAwayWhatTheSpeedsHaveInCommon) {
  RowTimeBelief belief = belief_of(std::nullopt);
  for (int i = 0; i < 5000; ++i) {
    const double off_s = kRolling_s - belief.begin(Frame{}).mean_s;
    belief.learn({.error_s = off_s, .information_1_s2 = 1e12, .motion_share = 0.3});
  }
  EXPECT_GT(belief.begin(Frame{}).sigma_s, 0.25 * 0.3 * kRolling_s);
}

/// Divided by a speed that is mostly noise an answer lies near 0, in every picture.
TEST(RowTimeBelief, LearnsNothingFromACameraThatHardlyMoves) {
  RowTimeBelief belief = belief_of(std::nullopt);
  for (int i = 0; i < 10000; ++i) {
    belief.begin(Frame{});
    belief.learn({.error_s = 1e-6 - belief.now().mean_s, .information_1_s2 = 1e12, .motion_share = 0.5});
  }
  EXPECT_GT(belief.begin(Frame{}).sigma_s, 25e-6);
}

TEST(RowTimeBelief, UnlearnsWhatWasWrong) {
  RowTimeBelief belief = belief_of(std::nullopt);
  Pictures(15e-6, 1e-6, 5).show(belief, 2000);
  Pictures(kRolling_s, 4e-6, 6).show(belief, 60);
  EXPECT_NEAR(belief.now().mean_s, kRolling_s, 3 * belief.now().sigma_s);
}

TEST(RowTimeBelief, BelievesWhatWasToldAgainWherePicturesComeBackToIt) {
  RowTimeBelief belief = belief_of(33us);
  EXPECT_TRUE(Pictures(5e-6, 2e-6, 7).show(belief, 200)) << "a sheet that hung elsewhere";
  EXPECT_EQ(belief.now().source, RowTimeSource::kContradicted);
  Pictures(kRolling_s, 2e-6, 8).show(belief, 400);
  EXPECT_EQ(belief.now().source, RowTimeSource::kTold);
  EXPECT_EQ(belief.now().mean_s, 33e-6);
}

TEST(RowTimeBelief, ForgetsPicturesOfAnotherMap) {
  RowTimeBelief belief = belief_of(33us);
  EXPECT_TRUE(Pictures(5e-6, 2e-6, 9).show(belief, 200));
  belief.forget_pictures();
  EXPECT_EQ(belief.begin(Frame{}).source, RowTimeSource::kTold);
  EXPECT_EQ(belief.now().sigma_s, 0);
}

/// Of one landmark, whose pictures tell little.
TEST(RowTimeBelief, UntoldItMayCountAsAGlobalShutterUntilPicturesContradict) {
  RowTimeBelief belief(std::nullopt, kRows, RowTimeBelief::Untold::kIsGlobal);
  EXPECT_EQ(belief.begin(Frame{}).sigma_s, 0);
  EXPECT_EQ(belief.now().source, RowTimeSource::kOpen);
  EXPECT_TRUE(Pictures(kRolling_s, 4e-6, 10).show(belief, 100));
  EXPECT_EQ(belief.now().source, RowTimeSource::kSeen) << "nobody has told it wrongly";
}

TEST(RowTimeBelief, WhatAFrameTellsComesFirst) {
  RowTimeBelief belief = belief_of(0us);
  Frame frame;
  frame.row_time = 20us;
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(belief.begin(frame).mean_s, 20e-6);
    EXPECT_EQ(belief.learn({.error_s = 13e-6, .information_1_s2 = 1e12}), RowTimeBelief::News::kNone);
  }
  EXPECT_EQ(belief.begin(Frame{}).mean_s, 0) << "and teaches nothing";
}

TEST(RowTimeBelief, APictureThatSaysNothingChangesNothing) {
  RowTimeBelief belief = belief_of(std::nullopt);
  const double before_s = belief.now().sigma_s;
  belief.learn({.error_s = 0, .information_1_s2 = 0});
  belief.learn({.error_s = 0, .information_1_s2 = 1e12, .motion_share = std::numeric_limits<double>::infinity()});
  belief.begin(Frame{});
  EXPECT_EQ(belief.now().sigma_s, before_s);
  EXPECT_EQ(belief.now().mean_s, 0);
}

}  // namespace
}  // namespace ninedot
