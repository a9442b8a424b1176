// What is told of a search that found nothing: sheets that are no landmark, each in its own way.
#include "detect/failed_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "detect/detector.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

test::Scene scene_with(const test::Sheet& sheet) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.2, .tilt_rad = 25 * kRadPerDeg, .roll_rad = 0.05});
  scene.sheets = {sheet};
  return scene;
}

/// The landmark with some of its discs left out.
test::Sheet sheet_without(std::initializer_list<std::size_t> left_out) {
  test::Sheet sheet = test::nine_dot_sheet();
  for (const std::size_t dot : left_out) sheet.discs[dot].radius_m = 0;
  std::erase_if(sheet.discs, [](const test::Disc& disc) { return disc.radius_m == 0; });
  return sheet;
}

class FailedSearchTest : public testing::Test {
 protected:
  /// The search of a picture in which there must be no landmark.
  FailedSearch search(const test::Scene& scene) {
    picture_ = test::render(scene, 1);
    EXPECT_FALSE(detector_.find_landmarks(picture_.view()).has_value());
    return detector_.failed_search();
  }
  static std::ptrdiff_t seen(const FailedSearch& failed) {
    return std::ranges::count_if(failed.dots, [](const DotObservation& dot) { return dot.seen; });
  }

  Detector detector_{CameraModel{}, LandmarkGeometry{}};
  test::Picture picture_;
};

TEST_F(FailedSearchTest, OfARingWithoutItsCentreSaysSoAndWhereItIs) {
  const FailedSearch failed = search(scene_with(sheet_without({8})));
  EXPECT_EQ(failed.refusal, Refusal::kNoCentre);
  EXPECT_EQ(seen(failed), 8);
  EXPECT_FALSE(failed.dots[kCentreDot].seen);
  // Where the whole landmark would have its dots, by a search that finds it; numbered from another dot, perhaps.
  const test::Picture whole = test::render(scene_with(test::nine_dot_sheet()), 1);
  Detector other{CameraModel{}, LandmarkGeometry{}};
  const auto found = other.find_landmarks(whole.view());
  ASSERT_TRUE(found.has_value());
  for (const DotObservation& dot : found->front().dots) {
    const auto nearest = std::ranges::min_element(
        failed.dots, {}, [&](const DotObservation& d) { return (d.centroid_px - dot.centroid_px).norm(); });
    EXPECT_LT((nearest->centroid_px - dot.centroid_px).norm(), 1.5);
    EXPECT_NEAR(nearest->semi_major_px, dot.semi_major_px, 0.15 * dot.semi_major_px);
    EXPECT_NEAR(nearest->semi_minor_px, dot.semi_minor_px, 0.15 * dot.semi_major_px);
  }
}

TEST_F(FailedSearchTest, OfHalfARingSaysThatTooFewAreThere) {
  const FailedSearch failed = search(scene_with(sheet_without({0, 1, 2, 3, 4, 5})));
  EXPECT_TRUE(failed.refusal == Refusal::kFewOutlines || failed.refusal == Refusal::kNone);
  EXPECT_LE(seen(failed), 3);
}

TEST_F(FailedSearchTest, ListsEveryDotThatItSawAsASpotTheLargestFirst) {
  const FailedSearch failed = search(scene_with(sheet_without({8})));
  ASSERT_GE(failed.spots.size(), 8U);
  EXPECT_TRUE(std::ranges::is_sorted(failed.spots, std::ranges::greater{}, &Blob::area_px2));
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot)
    EXPECT_TRUE(std::ranges::any_of(failed.spots, [&](const Blob& spot) {
      return (Eigen::Vector2d(spot.x_px, spot.y_px) - failed.dots[dot].centroid_px).norm() < 1;
    })) << dot;
}

TEST_F(FailedSearchTest, OfABareWallHasNoGuess) {
  test::Scene scene = scene_with(test::nine_dot_sheet());
  scene.sheets.clear();
  set_noise(scene.sensor, 1.5);
  const FailedSearch failed = search(scene);
  EXPECT_EQ(failed.refusal, Refusal::kNone);
  EXPECT_NEAR(failed.noise_lsb, 1.5, 0.3);
}

TEST_F(FailedSearchTest, SaysNothingOfThePictureBefore) {
  ASSERT_NE(search(scene_with(sheet_without({8}))).refusal, Refusal::kNone);
  test::Scene bare = scene_with(test::nine_dot_sheet());
  bare.sheets.clear();
  const FailedSearch failed = search(bare);
  EXPECT_EQ(failed.refusal, Refusal::kNone);
  EXPECT_LT(failed.spots.size(), 8U);
}

}  // namespace
}  // namespace ninedot
