#include "aim/landmark_chooser.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "tests/support/random.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

AimOptions choosing(LandmarkChoice choice) {
  AimOptions options;
  options.landmark = choice;
  options.landmark_id = 7;
  return options;
}

/// Frames every 28 ms.
class Frames {
 public:
  explicit Frames(LandmarkChoice choice) : unit(choosing(choice)) {}
  struct Seen {
    std::uint16_t id;
    double distance_m;
  };
  std::optional<std::uint16_t> show(std::initializer_list<Seen> seen) {
    now_ += 28ms;
    std::vector<AimSight> sights;
    for (const Seen& s : seen) sights.push_back({s.id, now_, {0, 0, s.distance_m}});
    const AimSight* const chosen = unit.choose(sights);
    return chosen != nullptr ? std::optional(chosen->id) : std::nullopt;
  }
  LandmarkChooser unit;

 private:
  MonoTime now_{100s};
};

TEST(LandmarkChooser, ByIdFollowsThatOneAlone) {
  Frames frames(LandmarkChoice::kById);
  EXPECT_EQ(frames.show({{3, 1}}), std::nullopt);
  EXPECT_EQ(frames.show({{3, 1}, {7, 5}}), 7);
}

TEST(LandmarkChooser, AsReportedTakesTheFirst) {
  Frames frames(LandmarkChoice::kReported);
  EXPECT_EQ(frames.show({{3, 4}, {7, 1}}), 3);
  EXPECT_EQ(frames.show({{7, 4}, {3, 1}}), 7);
  EXPECT_EQ(frames.show({}), std::nullopt);
}

TEST(LandmarkChooser, NearestTakesTheNearestAtOnceButNotToAndFroBetweenTwoEquallyFar) {
  Frames frames(LandmarkChoice::kNearest);
  EXPECT_EQ(frames.show({{1, 2.0}, {2, 1.9}}), 2);
  EXPECT_EQ(frames.show({{1, 1.7}, {2, 1.9}}), 1);
  test::Random random(1);
  int changes = 0;
  std::uint16_t last = 1;
  for (int i = 0; i < 500; ++i) {
    const auto now = frames.show({{1, 2 + 0.004 * random.normal()}, {2, 2 + 0.004 * random.normal()}});
    changes += *now != last ? 1 : 0;
    last = *now;
  }
  EXPECT_LE(changes, 1);
}

TEST(LandmarkChooser, HandsOverOnceAlongTheWay) {
  // Two landmarks 3 m apart on a wall 1.5 m away; both in the picture all along.
  Frames frames(LandmarkChoice::kHandOver);
  test::Random random(2);
  std::vector<std::uint16_t> order;
  double handed_over_at_m = 0;
  for (double x_m = 0; x_m < 3; x_m += 0.028) {
    const double a = std::hypot(x_m, 1.5) * (1 + 0.01 * random.normal());
    const double b = std::hypot(3 - x_m, 1.5) * (1 + 0.01 * random.normal());
    const auto now = frames.show({{1, a}, {2, b}});
    ASSERT_TRUE(now);
    if (!order.empty() && order.back() != *now) handed_over_at_m = x_m;
    if (order.empty() || order.back() != *now) order.push_back(*now);
  }
  EXPECT_EQ(order, (std::vector<std::uint16_t>{1, 2}));
  EXPECT_GT(handed_over_at_m, 1.95) << "not where they are equally far, at 1.5 m, nor 0.3 s later";
  EXPECT_LT(handed_over_at_m, 2.5);
}

TEST(LandmarkChooser, AFewFramesWithoutTheOneThatIsFollowedHandNothingOver) {
  Frames frames(LandmarkChoice::kHandOver);
  EXPECT_EQ(frames.show({{1, 1}, {2, 3}}), 1);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(frames.show({{2, 3}}), std::nullopt);
  EXPECT_EQ(frames.show({{1, 1}, {2, 3}}), 1);
  std::optional<std::uint16_t> now;
  for (int i = 0; i < 12; ++i) now = frames.show({{2, 3}});
  EXPECT_EQ(now, 2);
  EXPECT_EQ(frames.show({{1, 2.9}, {2, 3}}), 2) << "that it comes back is no reason to";
}

TEST(LandmarkChooser, WhatIsNearerForAMomentIsNotTaken) {
  Frames frames(LandmarkChoice::kHandOver);
  frames.show({{1, 2}});
  for (int i = 0; i < 50; ++i) EXPECT_EQ(frames.show({{1, 2}, {2, i % 5 == 0 ? 2.0 : 1.0}}), 1);
}

}  // namespace
}  // namespace ninedot
