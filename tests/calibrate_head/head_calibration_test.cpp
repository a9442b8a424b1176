// Heads that are known exactly. What is said of them must be right within what is said of its certainty.
#include "calibrate_head/head_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "calibrate_head/head_sufficiency.h"
#include "tests/calibrate_head/made_up_head.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

using test::made_up_stops;
using test::MadeUpAxis;
using test::MadeUpHeadOptions;

/// A hobby servo's pan, reversed, and a tilt whose play is as large as its spread.
MadeUpHeadOptions usual_head() {
  MadeUpHeadOptions options;
  options.body.tilt_axis_m = {0.012, 0, 0.045};
  options.body.camera_m = {0.031, -0.006, 0.022};
  options.body.camera_rpy_rad = {0.02, -0.04, 0.03};
  options.pan.scale = -1.08;
  options.pan.from_rad = -0.32, options.pan.to_rad = 0.32;
  options.pan.play_rad = 0.8 * kRadPerDeg, options.pan.spread_rad = 0.1 * kRadPerDeg;
  options.tilt.scale = 0.93;
  options.tilt.play_rad = 0.3 * kRadPerDeg, options.tilt.spread_rad = 0.1 * kRadPerDeg;
  return options;
}

BodyGeometry said_before() {
  BodyGeometry body;
  body.tilt_axis_m = {0, 0, 0.045};
  return body;
}

std::optional<HeadCalibration> calibrate(const MadeUpHeadOptions& options, const BodyGeometry& before = said_before()) {
  const std::vector<HeadStop> stops = made_up_stops(options);
  return calibrate_head(stops, {}, before, {});
}

/// True angle against the anchor's, where the play's middle counts.
double truth_of(const MadeUpAxis& axis, double told_rad) { return axis.true_rad(told_rad) - axis.true_rad(0); }

/// Errors over their own sigmas.
struct Deviates {
  double sum = 0, count = 0, worst = 0;
  void add(double error, double sigma) {
    const double deviate = std::abs(error / sigma);
    sum += deviate * deviate, ++count, worst = std::max(worst, deviate);
  }
  double rms() const { return std::sqrt(sum / count); }
};

/// The truth in the axes of the answer: the tilt axis's zero is where the table says it is.
void add_errors(const HeadCalibration& found, const MadeUpHeadOptions& truth, Deviates& chain, Deviates& tables) {
  chain.add(found.body.tilt_axis_m.x() - truth.body.tilt_axis_m.x(), found.tilt_axis_x_sigma_m);
  for (int i = 0; i < 3; ++i) {
    chain.add(found.body.camera_m(i) - truth.body.camera_m(i), found.camera_sigma_m(i));
    chain.add(found.body.camera_rpy_rad(i) - truth.body.camera_rpy_rad(i), found.camera_rpy_sigma_rad(i));
  }
  const auto add_axis = [&](const AxisCalibration& axis, const MadeUpAxis& true_axis) {
    for (const TablePoint& point : axis.points)
      if (std::abs(point.told_rad) > 1e-3)
        tables.add(point.angle_rad - truth_of(true_axis, point.told_rad), point.sigma_rad);
    tables.add(axis.play_rad - true_axis.play_rad, axis.play_sigma_rad);
  };
  add_axis(found.pan, truth.pan);
  add_axis(found.tilt, truth.tilt);
}

TEST(HeadCalibration, FindsAReversedBentAxisAndTheLengthsToMillimetres) {
  MadeUpHeadOptions options = usual_head();
  options.landmarks = 3, options.pan.from_rad = -0.7, options.pan.to_rad = 0.7, options.pan.stops = 15;
  options.pan.bend_rad = 0.012;
  const auto found = calibrate(options);
  ASSERT_TRUE(found);
  EXPECT_LT(std::abs(found->body.tilt_axis_m.x() - 0.012), 2e-3);
  EXPECT_LT((found->body.camera_m - usual_head().body.camera_m).norm(), 4e-3);
  EXPECT_LT((found->body.camera_rpy_rad - usual_head().body.camera_rpy_rad).norm(), 0.2 * kRadPerDeg);
  EXPECT_NEAR(found->pan.play_rad * kDegPerRad, 0.8, 0.1);
  EXPECT_NEAR(found->tilt.play_rad * kDegPerRad, 0.3, 0.1);
  EXPECT_NEAR(found->pan.spread_rad * kDegPerRad, 0.1, 0.03);
  EXPECT_NEAR(found->body.pan_sigma_rad * kDegPerRad, std::hypot(0.4, 0.1), 0.05);
  EXPECT_GE(found->pan.points.size(), 4U) << "its bend needs more than a straight line";
  EXPECT_EQ(found->tilt.points.size(), 2U) << "it is straight";
  EXPECT_TRUE(what_head_lacks(*found).empty());
  EXPECT_EQ(found->left_out, 0U);
}

TEST(HeadCalibration, ForetellsDirectionsAsWellAsItSays) {
  const auto found = calibrate(usual_head());
  ASSERT_TRUE(found);
  // Half the play and the spread of both axes.
  const double truth_rad = std::hypot(0.4, 0.1, std::hypot(0.15, 0.1)) * kRadPerDeg;
  EXPECT_NEAR(found->foretold_rad, truth_rad, 0.2 * truth_rad);
  EXPECT_GT(found->foretold_before_rad, 10 * kRadPerDeg) << "one axis was reversed";
}

TEST(HeadCalibration, KeepsWhatNobodyCanSee) {
  BodyGeometry before = said_before();
  before.pan_axis_m = {0.1, 0.2, 0.3};
  before.mount_rpy_rad = {0, 0, 0.5};
  before.tilt_axis_m.y() = 0.007;
  before.mount_sigma_m = 0.002;
  MadeUpHeadOptions options = usual_head();
  const auto found = calibrate(options, before);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->body.pan_axis_m, before.pan_axis_m);
  EXPECT_EQ(found->body.mount_rpy_rad, before.mount_rpy_rad);
  EXPECT_EQ(found->body.tilt_axis_m.y(), before.tilt_axis_m.y());
  EXPECT_EQ(found->body.tilt_axis_m.z(), before.tilt_axis_m.z());
  EXPECT_EQ(found->body.mount_sigma_m, before.mount_sigma_m);
  // Of the two places along the tilt axis only the sum is seen.
  EXPECT_NEAR(found->body.tilt_axis_m.y() + found->body.camera_m.y(), options.body.camera_m.y(), 2e-3);
}

TEST(HeadCalibration, FindsAHeadOfWhichBothAxesAreReversed) {
  MadeUpHeadOptions options = usual_head();
  options.tilt.scale = -1.1;
  const auto found = calibrate(options);
  ASSERT_TRUE(found);
  EXPECT_LT((found->body.camera_m - options.body.camera_m).norm(), 4e-3);
  EXPECT_EQ(found->left_out, 0U);
}

TEST(HeadCalibration, TakesAStopThatIsReadAsItsMirrorImage) {
  MadeUpHeadOptions options = usual_head();
  options.mirrored_every = 3;
  const auto found = calibrate(options);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->left_out, 0U) << "its dots are where they are, however they are read";
  EXPECT_LT((found->body.camera_m - options.body.camera_m).norm(), 4e-3);
}

TEST(HeadCalibration, LeavesOutStopsAtWhichTheHeadSlipped) {
  MadeUpHeadOptions options = usual_head();
  options.slips_every = 9;
  const std::size_t slips = made_up_stops(options).size() / 9;
  const auto found = calibrate(options);
  ASSERT_TRUE(found);
  EXPECT_GE(slips, 3U);
  EXPECT_GE(found->left_out, slips);
  EXPECT_LE(found->left_out, slips + 1);
  EXPECT_LT((found->body.camera_m - options.body.camera_m).norm(), 5e-3);
  EXPECT_TRUE(what_head_lacks(*found).empty());
}

TEST(HeadCalibration, LeavesOutALandmarkThatWasBumpedAtTheEnd) {
  MadeUpHeadOptions options = usual_head();
  const std::size_t all = made_up_stops(options).size();
  options.moved_after = all - 8;
  const auto found = calibrate(options);
  ASSERT_TRUE(found);
  EXPECT_GE(found->left_out, 7U);
  EXPECT_LE(found->left_out, 10U);
  EXPECT_LT((found->body.camera_m - options.body.camera_m).norm(), 5e-3);
}

TEST(HeadCalibration, RefusesWhenTheLandmarkWasMovedHalfWay) {
  MadeUpHeadOptions options = usual_head();
  options.moved_after = made_up_stops(options).size() / 2;
  const auto found = calibrate(options);
  ASSERT_TRUE(found);
  EXPECT_FALSE(what_head_lacks(*found).empty());
}

TEST(HeadSufficiency, SaysThatAnAxisStandsStillAndNothingElse) {
  HeadCalibration calibration;
  calibration.stops = 40;
  calibration.camera_sigma_m.setConstant(1);
  calibration.pan.points = {{-0.3, 0.3, 0.001}, {0.3, -0.3, 0.001}};
  calibration.tilt.points = {{-0.2, 0.001, 0.1}, {0.2, -0.001, 0.1}};
  const std::vector<std::string> lacks = what_head_lacks(calibration);
  ASSERT_EQ(lacks.size(), 1U);
  EXPECT_EQ(lacks[0].rfind("the tilt axis turned by 0.1 degrees where it was told 23", 0), 0U) << lacks[0];
  calibration.tilt.points = {{-0.2, -0.1, 0.001}, {0.2, 0.1, 0.001}};
  ASSERT_EQ(what_head_lacks(calibration).size(), 1U);
  EXPECT_EQ(what_head_lacks(calibration)[0].rfind("lengths are uncertain", 0), 0U);
}

TEST(HeadCalibration, MakesNothingOfStopsThatHaveNothingToDoWithEachOther) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    test::Random random(seed);
    std::vector<HeadStop> stops = made_up_stops(usual_head());
    for (HeadStop& stop : stops) stop.told = {random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3)};
    const auto found = calibrate_head(stops, {}, said_before(), {});
    EXPECT_TRUE(!found || !what_head_lacks(*found).empty());
  }
}

TEST(HeadCalibration, SaysHowFarTheAxesAreFromSquare) {
  MadeUpHeadOptions options = usual_head();
  options.skew_rad = 0.8 * kRadPerDeg;
  const auto found = calibrate(options);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->skew_rad, options.skew_rad, 3 * found->skew_sigma_rad);
  EXPECT_GT(found->skew_rad, 4 * found->skew_sigma_rad);
  const auto square = calibrate(usual_head());
  ASSERT_TRUE(square);
  EXPECT_LT(std::abs(square->skew_rad), 4 * square->skew_sigma_rad);
}

TEST(HeadCalibration, KnowsNoPlayOfAnAxisThatCameFromOneSideOnly) {
  std::vector<HeadStop> stops = made_up_stops(usual_head());
  for (HeadStop& stop : stops) stop.pan_side = 1;
  const auto found = calibrate_head(stops, {}, said_before(), {});
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->pan.sees_play);
  EXPECT_NEAR(found->pan.play_rad, 0, 1e-6);
  EXPECT_TRUE(found->tilt.sees_play);
}

TEST(HeadCalibration, EndsWhenItIsTold) {
  const std::vector<HeadStop> stops = made_up_stops(usual_head());
  EXPECT_FALSE(calibrate_head(stops, {}, said_before(), [] { return false; }));
}

class HeadCalibrationFigures : public testing::TestWithParam<int> {};

TEST_P(HeadCalibrationFigures, ErrorsAreWithinOneAndAHalfOfTheirSigmas) {
  Deviates chain, tables;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    test::Random random(1000 * static_cast<std::uint64_t>(GetParam()) + seed);
    MadeUpHeadOptions options = usual_head();
    options.seed = seed + 100 * static_cast<std::uint64_t>(GetParam());
    options.body.tilt_axis_m.x() = random.uniform(-0.03, 0.03);
    for (int i = 0; i < 3; ++i) {
      options.body.camera_m(i) = random.uniform(-0.05, 0.05);
      options.body.camera_rpy_rad(i) = random.uniform(-0.1, 0.1);
    }
    options.pan.scale = random.uniform(0.85, 1.15) * (random.uniform(-1, 1) > 0 ? 1 : -1);
    options.tilt.scale = random.uniform(0.85, 1.15);
    if (GetParam() == 1) options.landmarks = 3, options.pan.from_rad = -0.7, options.pan.to_rad = 0.7;
    if (GetParam() == 2)  // an encoder, whose angles are as certain as the pictures
      options.pan.play_rad = options.tilt.play_rad = 0, options.pan.spread_rad = options.tilt.spread_rad = 1e-4,
      options.noise_px = 0.1, options.distance_m = 1.6;
    const auto found = calibrate(options);
    ASSERT_TRUE(found);
    add_errors(*found, options, chain, tables);
  }
  EXPECT_LT(chain.rms(), 1.5);
  EXPECT_GT(chain.rms(), 0.5);
  EXPECT_LT(tables.rms(), 1.5);
  EXPECT_GT(tables.rms(), 0.5);
  EXPECT_LT(chain.worst, 5);
  EXPECT_LT(tables.worst, 5);
  std::printf("chain %.2f, worst %.2f; tables %.2f, worst %.2f\n", chain.rms(), chain.worst, tables.rms(),
              tables.worst);
}

INSTANTIATE_TEST_SUITE_P(OfHeads, HeadCalibrationFigures, testing::Values(0, 1, 2));

}  // namespace
}  // namespace ninedot
