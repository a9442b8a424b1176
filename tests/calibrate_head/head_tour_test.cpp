// A head's tour, without a head: who drives it here sees a landmark within a window of told angles.
#include "calibrate_head/head_tour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/units.h"

namespace ninedot {
namespace {

using Part = HeadTour::Part;

HeadTourOptions options_of_the_test() {
  return {.min = {-0.8, -0.5},
          .max = {0.8, 0.5},
          .start = {0.1, 0},
          .home = {0.05, 0.02},
          .half_width_rad = 0.4,
          .half_height_rad = 0.3,
          .columns = 4,
          .rows = 3};
}

/// In sight where the told angles are no farther from it than half the picture.
struct Window {
  HeadAngles middle;
  double pan_rad = 0.35, tilt_rad = 0.25;

  std::optional<Eigen::Vector2d> seen_from(const HeadAngles& at) const {
    if (std::abs(at.pan_rad - middle.pan_rad) > pan_rad || std::abs(at.tilt_rad - middle.tilt_rad) > tilt_rad)
      return std::nullopt;
    return Eigen::Vector2d(at.pan_rad - middle.pan_rad, at.tilt_rad - middle.tilt_rad);
  }
};

struct Visit {
  Part part;
  HeadAngles at;
};

std::vector<Visit> follow(HeadTour& tour, const Window& window) {
  std::vector<Visit> visits;
  while (tour.part() != Part::kHome && visits.size() < 1000) {
    visits.push_back({tour.part(), tour.goal()});
    for (int looks = 0; !tour.look(window.seen_from(tour.goal())); ++looks) {
      EXPECT_LT(looks, 20);
      if (looks > 20) return visits;
    }
  }
  return visits;
}

TEST(HeadTour, FindsALandmarkBesideWhereItWaits) {
  HeadTour tour(options_of_the_test());
  const Window window{{0.6, 0.1}};
  const std::vector<Visit> visits = follow(tour, window);
  EXPECT_EQ(visits.front().at, (HeadAngles{0.1, 0}));
  EXPECT_EQ(visits.front().part, Part::kFind);
  EXPECT_TRUE(std::ranges::any_of(visits, [](const Visit& visit) { return visit.part == Part::kGrid; }));
}

TEST(HeadTour, StaysWithinTheLimitsAndWhereALandmarkIsInSight) {
  HeadTour tour(options_of_the_test());
  const Window window{{0.6, 0.1}};
  for (const Visit& visit : follow(tour, window)) {
    EXPECT_LE(std::abs(visit.at.pan_rad), 0.8);
    EXPECT_LE(std::abs(visit.at.tilt_rad), 0.5);
    if (visit.part == Part::kGrid) {
      EXPECT_TRUE(window.seen_from(visit.at));
    }
  }
}

TEST(HeadTour, ComesFromBothSidesEverywhereAndToNoPlaceTwice) {
  HeadTour tour(options_of_the_test());
  std::vector<HeadAngles> grid;
  for (const Visit& visit : follow(tour, {{0, 0}}))
    if (visit.part == Part::kGrid) grid.push_back(visit.at);
  ASSERT_EQ(grid.size(), 20U) << "three rows of four, and two between them on the way back";
  std::array<int, 2> pan_from{}, tilt_from{};  // below, above
  for (std::size_t i = 1; i < grid.size(); ++i) {
    const double pan = grid[i].pan_rad - grid[i - 1].pan_rad, tilt = grid[i].tilt_rad - grid[i - 1].tilt_rad;
    if (std::abs(pan) > 0.01) ++pan_from[pan > 0 ? 0 : 1];
    if (std::abs(tilt) > 0.01) ++tilt_from[tilt > 0 ? 0 : 1];
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT(std::abs(grid[i].pan_rad - grid[k].pan_rad), 1e-3);
  }
  EXPECT_GE(*std::ranges::min_element(pan_from), 6);
  EXPECT_EQ(tilt_from, (std::array<int, 2>{2, 2}));
  const auto [left, right] = std::ranges::minmax(grid, {}, &HeadAngles::pan_rad);
  EXPECT_LT(left.pan_rad, -0.25);
  EXPECT_GT(right.pan_rad, 0.25);
}

TEST(HeadTour, GoesHomeWhenThereIsNoLandmark) {
  HeadTour tour(options_of_the_test());
  const std::vector<Visit> visits = follow(tour, {{5, 5}});
  EXPECT_GT(visits.size(), 6U) << "it looks everywhere before";
  EXPECT_EQ(tour.goal(), (HeadAngles{0.05, 0.02}));
  for (const Visit& visit : visits) EXPECT_EQ(visit.part, Part::kFind);
}

TEST(HeadTour, GoesHomeWithoutAGridWhereTheLandmarkStaysInSightTooBriefly) {
  HeadTour tour(options_of_the_test());
  for (const Visit& visit : follow(tour, {{0.1, 0}, 0.35, 0.1})) EXPECT_NE(visit.part, Part::kGrid);
  EXPECT_EQ(tour.stops_planned(), 0U);
}

TEST(HeadTour, WaitsUntilThePictureIsAtRest) {
  HeadTour tour(options_of_the_test());
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(tour.look(Eigen::Vector2d(0.01 * i, 0))) << "the head still turns";
  int more = 0;
  while (!tour.look(Eigen::Vector2d(0.1, 0))) ++more;
  EXPECT_GT(more, 10) << "it came to rest late, so that it has to be seen at rest for longer";
  EXPECT_LT(more, 40);
}

TEST(HeadTour, GoesOnWithoutAPlaceThatNeverComesToRest) {
  HeadTour tour(options_of_the_test());
  int looks = 1;
  while (!tour.look(Eigen::Vector2d(0.01 * (looks % 2), 0)) && looks < 1000) ++looks;
  EXPECT_LT(looks, 200);
}

TEST(HeadTour, GoesOnWithoutAPlaceThatTheHeadCantReach) {
  HeadTour tour(options_of_the_test());
  const HeadAngles first = tour.goal();
  tour.skip();
  EXPECT_NE(tour.goal(), first);
}

}  // namespace
}  // namespace ninedot
