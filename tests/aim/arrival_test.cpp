#include "aim/arrival.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using enum OrderProgress;

AimOptions options() {
  AimOptions options;
  options.pan = options.tilt = {-1, 1, 1};
  return options;
}

constexpr AimOrder kPointLeft{false, {0.5, 0}, 1};

/// Steps every 20 ms from where the clock stands.
class Clocked {
 public:
  OrderProgress step(const AimOrder& order, const ArrivalSight& sight) {
    now += 20ms;
    return unit.step(now, order, sight);
  }
  OrderProgress steps(std::chrono::nanoseconds time, const AimOrder& order, const ArrivalSight& sight) {
    OrderProgress progress = kNone;
    for (const MonoTime end = now + time; now < end;) progress = step(order, sight);
    return progress;
  }
  Arrival unit{options()};
  MonoTime now{100s};
};

TEST(Arrival, KnowsOfNoOrderBeforeTheFirst) {
  Clocked clocked;
  EXPECT_EQ(clocked.steps(10s, {true, {}}, {}), kNone);
}

TEST(Arrival, IsDoneOnlyWhenTheHeadStandsThere) {
  Clocked clocked;
  for (int i = 0; i <= 25; ++i)
    EXPECT_EQ(clocked.step(kPointLeft, {.head = {0.02 * i, 0}, .at_goal = i == 25}), kRunning) << i;
  EXPECT_EQ(clocked.steps(Arrival::kStanding - 40ms, kPointLeft, {.head = {0.5, 0}, .at_goal = true}), kRunning);
  EXPECT_EQ(clocked.steps(60ms, kPointLeft, {.head = {0.5, 0}, .at_goal = true}), kDone);
  EXPECT_EQ(clocked.steps(10s, kPointLeft, {.inhibited = true}), kDone) << "what was done stays done";
}

TEST(Arrival, AHeadThatSaysThatItIsThereBeforeItWasToldToGoIsNotDone) {
  Clocked clocked;
  EXPECT_EQ(clocked.steps(2s, kPointLeft, {.head = {0.5, 0}, .at_goal = false}), kRunning);
}

TEST(Arrival, FailsAtOnceWhileInhibitedAndSoonWhenTheHeadDoesNotAnswer) {
  Clocked inhibited;
  EXPECT_EQ(inhibited.step(kPointLeft, {.inhibited = true}), kFailed);
  Clocked silent;
  EXPECT_EQ(silent.steps(900ms, kPointLeft, {.failed = true}), kRunning) << "one refused command is no failed head";
  EXPECT_EQ(silent.steps(300ms, kPointLeft, {.failed = true}), kFailed);
}

TEST(Arrival, FailsAtTheEndOfTheRangeOnceTheHeadStandsThere) {
  Clocked clocked;
  const ArrivalSight at_end{.head = {0.3, 0}, .at_goal = true, .limited = true};
  EXPECT_EQ(clocked.steps(900ms, kPointLeft, at_end), kRunning);
  EXPECT_EQ(clocked.steps(300ms, kPointLeft, at_end), kFailed);
}

TEST(Arrival, FailsWhenTheHeadIsNotThereAfterItsTime) {
  Clocked clocked;
  // 0.5 rad at 1 rad/s: 0.5 s, a quarter more, and the grace.
  EXPECT_EQ(clocked.steps(5500ms, kPointLeft, {.head = {0.1, 0}, .at_goal = true}), kRunning);
  EXPECT_EQ(clocked.steps(300ms, kPointLeft, {.head = {0.1, 0}, .at_goal = true}), kFailed);
}

TEST(Arrival, ANewerOrderBeginsAnew) {
  Clocked clocked;
  ASSERT_EQ(clocked.step(kPointLeft, {.inhibited = true}), kFailed);
  AimOrder other = kPointLeft;
  other.number = 2;
  EXPECT_EQ(clocked.step(other, {}), kRunning);
}

TEST(Arrival, ToFollowIsDoneAsSoonAsTheHeadFollows) {
  Clocked clocked;
  EXPECT_EQ(clocked.step({true, {}, 5}, {}), kDone);
  EXPECT_EQ(clocked.step({true, {}, 6}, {.inhibited = true}), kFailed);
  EXPECT_EQ(clocked.step({true, {}, 7}, {.failed = true}), kRunning);
}

}  // namespace
}  // namespace ninedot
