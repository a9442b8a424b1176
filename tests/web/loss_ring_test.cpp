#include "programs/web/loss_ring.h"

#include <gtest/gtest.h>

#include "tests/web/recording_frames.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Phase = LossRing::Phase;

LossRules rules_of(std::chrono::nanoseconds before) {
  LossRules rules;
  rules.before = before;
  return rules;
}

void take(LossRing& ring, MadeUpService& service, int frames, bool is_valid) {
  for (int i = 0; i < frames; ++i) {
    QueuedFrame frame = service.next(is_valid);
    ring.take(frame.copy, 10);
  }
}

TEST(LossRing, HoldsEveryPixelAsItCame) {
  LossRing ring(rules_of(2s));
  MadeUpService service;
  take(ring, service, 45, true);
  ASSERT_EQ(ring.size(), 31U) << "two seconds, the one after them, and the frame that they begin with";
  for (std::size_t i = 0; i < ring.size(); ++i) {
    EXPECT_EQ(ring.at(i).publication, 15 + i);
    EXPECT_EQ(ring.at(i).pixels, std::vector<std::uint8_t>(32 * 16, static_cast<std::uint8_t>(15 + i)));
  }
}

TEST(LossRing, WatchesFromTheFirstValidPoseOn) {
  LossRing ring(rules_of(2s));
  MadeUpService service;
  take(ring, service, 40, false);
  EXPECT_EQ(ring.phase(), Phase::kBlind) << "what was never there was not lost";
  take(ring, service, 1, true);
  EXPECT_EQ(ring.phase(), Phase::kWatching);
}

TEST(LossRing, TakesAShortGapForNone) {
  LossRing ring(rules_of(2s));
  MadeUpService service;
  take(ring, service, 10, true);
  take(ring, service, 4, false);
  EXPECT_EQ(ring.phase(), Phase::kWatching);
  take(ring, service, 1, true);
  take(ring, service, 4, false);
  EXPECT_EQ(ring.phase(), Phase::kWatching) << "counted anew";
  take(ring, service, 1, false);
  EXPECT_EQ(ring.phase(), Phase::kLost);
}

TEST(LossRing, IsReadyASecondAfterTheLastValidPoseAndKeepsThat) {
  LossRing ring(rules_of(2s));
  MadeUpService service;
  take(ring, service, 30, true);
  take(ring, service, 9, false);
  EXPECT_EQ(ring.phase(), Phase::kLost);
  take(ring, service, 1, true);
  ASSERT_EQ(ring.phase(), Phase::kReady) << "though it came back";
  const std::uint64_t newest = ring.at(ring.size() - 1).publication;
  EXPECT_EQ(newest, 40U);
  take(ring, service, 20, true);
  EXPECT_EQ(ring.at(ring.size() - 1).publication, newest) << "until it is saved";
  ring.release();
  EXPECT_EQ(ring.size(), 0U);
  EXPECT_EQ(ring.phase(), Phase::kBlind);
}

TEST(LossRing, RestsAfterALossAndCountsWhatItLeavesOut) {
  LossRing ring(rules_of(1s));
  MadeUpService service;
  for (int i = 0; i < 10; ++i) {
    take(ring, service, 20, true);
    take(ring, service, 15, false);
    if (ring.phase() == Phase::kReady) ring.release();
  }
  EXPECT_EQ(ring.skipped(), 8U) << "35 s: one at 2 s, one at 33 s";
}

TEST(LossRing, NeverHoldsMoreThanItsMemoryAndThinsEvenly) {
  LossRules rules = rules_of(9s);
  rules.most_bytes = 20 * 32 * 16;
  LossRing ring(rules);
  MadeUpService service;
  take(ring, service, 300, true);
  EXPECT_EQ(ring.bytes(), rules.most_bytes);
  EXPECT_EQ(ring.spacing(), 500ms);
  ASSERT_EQ(ring.size(), 20U);
  for (std::size_t i = 1; i < ring.size(); ++i) EXPECT_EQ(ring.at(i).publication - ring.at(i - 1).publication, 5U);
}

TEST(LossRing, IsReadyWhereNothingMoreComes) {
  LossRing ring(rules_of(2s));
  MadeUpService service;
  take(ring, service, 10, true);
  ring.expire();
  EXPECT_EQ(ring.phase(), Phase::kWatching) << "a camera that went is no landmark that was lost";
  take(ring, service, 6, false);
  ring.expire();
  EXPECT_EQ(ring.phase(), Phase::kReady);
}

}  // namespace
}  // namespace ninedot
