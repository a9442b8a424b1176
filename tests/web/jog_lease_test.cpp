#include "programs/web/jog_lease.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Phase = JogLease::Phase;

constexpr const char* kOurs = "ours0000";
constexpr const char* kOther = "other000";
const MonoTime kStart{100s};

AimRequest jog(std::uint32_t number, MonoTime seen, double pan_deg_s, const char* viewer = kOurs) {
  return {AimVerb::kJog, viewer, number, seen, {pan_deg_s, 0}};
}

/// With a page that has the head from kStart on.
JogLease held(bool followed = true) {
  JogLease lease;
  lease.take(kOurs, "10.0.0.7", kStart);
  lease.grant(followed, kStart);
  return lease;
}

TEST(WebJogLease, IsGivenToOnePageAtATime) {
  JogLease lease;
  EXPECT_TRUE(lease.take(kOurs, "10.0.0.7", kStart));
  EXPECT_EQ(lease.phase(), Phase::kAsked);
  EXPECT_FALSE(lease.take(kOther, "10.0.0.8", kStart));
  lease.grant(true, kStart);
  EXPECT_EQ(lease.phase(), Phase::kHeld);
  EXPECT_FALSE(lease.take(kOther, "10.0.0.8", kStart));
  EXPECT_FALSE(lease.follow(kOther, "10.0.0.8", kStart));
  EXPECT_FALSE(lease.give(kOther, kStart));
  EXPECT_FALSE(lease.jog(jog(1, kStart, 5, kOther), kStart));
  EXPECT_TRUE(lease.take(kOurs, "10.0.0.7", kStart)) << "who has it has it";
  EXPECT_EQ(lease.phase(), Phase::kHeld);
  EXPECT_EQ(lease.peer(), "10.0.0.7");
  EXPECT_TRUE(lease.is_holder(kOurs));
  EXPECT_FALSE(lease.is_holder(kOther));
}

TEST(WebJogLease, MovesNothingBeforeItIsGranted) {
  JogLease lease;
  lease.take(kOurs, "", kStart);
  EXPECT_TRUE(lease.jog(jog(1, kStart, 5), kStart));
  EXPECT_FALSE(lease.rates(kStart).moves());
}

TEST(WebJogLease, MovesForSoLongAfterTheAnswerThatThePageHadSeen) {
  JogLease lease = held();
  EXPECT_TRUE(lease.jog(jog(1, kStart, 5), kStart + 30ms));
  EXPECT_EQ(lease.rates(kStart + 30ms).pan_deg_s, 5);
  EXPECT_TRUE(lease.rates(kStart + JogLease::kReach - 1ms).moves());
  EXPECT_FALSE(lease.rates(kStart + JogLease::kReach).moves()) << "counted from the answer, not from the arrival";
  EXPECT_EQ(lease.step(kStart + 1s), Phase::kHeld) << "it stands, and waits";
  EXPECT_TRUE(lease.jog(jog(2, kStart + 1s, -5), kStart + 1s));
  EXPECT_EQ(lease.rates(kStart + 1s).pan_deg_s, -5);
}

TEST(WebJogLease, StopsAtOnceWhenToldTo) {
  JogLease lease = held();
  lease.jog(jog(1, kStart, 5), kStart);
  lease.jog(jog(2, kStart, 0), kStart + 10ms);
  EXPECT_FALSE(lease.rates(kStart + 10ms).moves());
}

TEST(WebJogLease, IsMovedByNothingThatWasLongUnderWay) {
  JogLease lease = held();
  lease.jog(jog(1, kStart, 5), kStart + JogLease::kReach);
  EXPECT_FALSE(lease.rates(kStart + JogLease::kReach).moves());
  // A network that held back a second of them and lets all go at once.
  for (std::uint32_t i = 2; i < 30; ++i) lease.jog(jog(i, kStart + i * 30ms, 5), kStart + 2s);
  EXPECT_FALSE(lease.rates(kStart + 2s).moves());
}

TEST(WebJogLease, IsMovedByNothingThatWasOvertaken) {
  JogLease lease = held();
  lease.jog(jog(2, kStart, 0), kStart + 10ms);
  lease.jog(jog(1, kStart, 5), kStart + 11ms);
  EXPECT_FALSE(lease.rates(kStart + 11ms).moves()) << "the stop was sent after it";
  lease.jog(jog(2, kStart, 5), kStart + 12ms);
  EXPECT_FALSE(lease.rates(kStart + 12ms).moves()) << "nor by the same one twice";
}

TEST(WebJogLease, IsMovedByNoTimeThatHasNotBeenYet) {
  JogLease lease = held();
  lease.jog(jog(1, kStart + 1h, 5), kStart);
  EXPECT_FALSE(lease.rates(kStart).moves());
  EXPECT_FALSE(lease.rates(kStart + 1h).moves());
}

TEST(WebJogLease, GoesBackWhenThePageIsHeardNoMore) {
  for (const bool followed : {true, false}) {
    JogLease lease = held(followed);
    lease.jog(jog(1, kStart, 0), kStart + 1s);
    EXPECT_EQ(lease.step(kStart + 1s + JogLease::kAway - 1ms), Phase::kHeld);
    EXPECT_EQ(lease.step(kStart + 1s + JogLease::kAway), Phase::kReturning);
    EXPECT_EQ(lease.must_follow(), followed) << "to what it did before";
    EXPECT_FALSE(lease.from_anybody());
    EXPECT_FALSE(lease.is_holder(kOurs));
    EXPECT_NE(lease.note(), "");
    EXPECT_FALSE(lease.jog(jog(2, kStart + 6s, 5), kStart + 6s));
    EXPECT_FALSE(lease.take(kOther, "", kStart + 6s)) << "first it goes back";
    lease.end("");
    EXPECT_TRUE(lease.take(kOther, "", kStart + 6s));
  }
}

TEST(WebJogLease, GoesBackWhenItIsForgotten) {
  JogLease lease = held();
  lease.jog(jog(1, kStart, 5), kStart);
  std::uint32_t number = 2;
  MonoTime now = kStart;
  for (; now < kStart + JogLease::kIdle; now += 400ms) {
    EXPECT_EQ(lease.step(now), Phase::kHeld);
    lease.jog(jog(number++, now, 0), now);
  }
  EXPECT_EQ(lease.step(now), Phase::kReturning) << "heard, but not jogged";
}

TEST(WebJogLease, AsksAServiceThatIsSilentForSomeTimeOnly) {
  JogLease lease = held();
  EXPECT_TRUE(lease.give(kOurs, kStart + 1s));
  EXPECT_EQ(lease.step(kStart + 1s + JogLease::kInsists - 1ms), Phase::kReturning);
  lease.give_back("again", kStart + 5s);
  EXPECT_EQ(lease.step(kStart + 1s + JogLease::kInsists), Phase::kFree);
  EXPECT_NE(lease.note().find("did not answer"), std::string::npos);
}

TEST(WebJogLease, AHeadThatWasNotGrantedHasNothingToGoBackFrom) {
  JogLease lease;
  lease.take(kOurs, "", kStart);
  EXPECT_EQ(lease.step(kStart + JogLease::kAway), Phase::kFree);
  lease.take(kOurs, "", kStart);
  lease.end("a controller has it");
  EXPECT_EQ(lease.note(), "a controller has it");
  lease.grant(true, kStart);
  EXPECT_EQ(lease.phase(), Phase::kFree) << "too late";
  EXPECT_EQ(lease.note(), "a controller has it");
}

TEST(WebJogLease, FollowsAgainWhoeverSentItElsewhere) {
  JogLease lease;
  EXPECT_TRUE(lease.follow(kOurs, "", kStart));
  EXPECT_EQ(lease.phase(), Phase::kReturning);
  EXPECT_TRUE(lease.must_follow() && lease.from_anybody());
  lease.end("");
  lease.take(kOurs, "", kStart);
  lease.grant(false, kStart);
  EXPECT_FALSE(lease.from_anybody());
  EXPECT_TRUE(lease.follow(kOurs, "", kStart)) << "though it did not before";
  EXPECT_TRUE(lease.must_follow());
}

TEST(WebJogLease, ClearsUpAfterAProcessThatWasKilled) {
  JogLease lease;
  lease.clear_up(kStart);
  EXPECT_EQ(lease.phase(), Phase::kReturning);
  EXPECT_TRUE(lease.must_follow());
  EXPECT_FALSE(lease.from_anybody());
}

}  // namespace
}  // namespace ninedot
