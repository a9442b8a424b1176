#include "drivers/servo/visca_dialogue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

const Bytes kAddressSet = {0x88, 0x30, 0x01, 0xFF}, kIfClear = {0x88, 0x01, 0x00, 0x01, 0xFF};
const Bytes kAskPosition = {0x81, 0x09, 0x06, 0x12, 0xFF}, kAskZoom = {0x81, 0x09, 0x04, 0x47, 0xFF};
const Bytes kStop = {0x81, 0x01, 0x06, 0x01, 0x18, 0x14, 0x03, 0x03, 0xFF};
const Bytes kAck1 = {0x90, 0x41, 0xFF}, kAck2 = {0x90, 0x42, 0xFF};
const Bytes kDone1 = {0x90, 0x51, 0xFF}, kDone2 = {0x90, 0x52, 0xFF};
const Bytes kAtZero = {0x90, 0x50, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF};
const Bytes kNothing;

Bytes cancel(int socket) { return {0x81, static_cast<std::uint8_t>(0x20 + socket), 0xFF}; }
Bytes fault(int socket, int code) {
  return {0x90, static_cast<std::uint8_t>(0x60 + socket), static_cast<std::uint8_t>(code), 0xFF};
}
/// For 0 <= steps < 16: short to read.
Bytes move(int pan) {
  return {0x81, 0x01, 0x06, 0x02, 0x18, 0x14, 0, 0, 0, static_cast<std::uint8_t>(pan), 0, 0, 0, 0, 0xFF};
}

/// A dialogue and a clock that stands still until it is moved.
class ViscaDialogueTest : public testing::Test {
 protected:
  explicit ViscaDialogueTest(const ViscaOptions& with = options()) : dialogue_(with) {}

  static ViscaOptions options() {
    ViscaOptions options;
    options.device = "none";
    return options;
  }

  Bytes next() {
    const auto packet = dialogue_.next_packet(now_);
    return packet ? Bytes(packet->bytes().begin(), packet->bytes().end()) : kNothing;
  }
  void hear(const Bytes& bytes) { dialogue_.receive(bytes, now_); }
  void want(int pan) { dialogue_.order({ViscaOrder::Kind::kMove, {static_cast<std::int16_t>(pan), 0}, ++sequence_}); }
  void want_stop() { dialogue_.order({ViscaOrder::Kind::kStop, {}, ++sequence_}); }

  void get_ready() {
    dialogue_.begin(now_);
    ASSERT_EQ(next(), kAddressSet);
    hear({0x88, 0x30, 0x02, 0xFF});
    ASSERT_EQ(next(), kIfClear);
    hear(kIfClear);
    ASSERT_EQ(next(), kAskPosition);
    hear(kAtZero);
    ASSERT_TRUE(dialogue_.is_ready());
    ASSERT_EQ(next(), first_when_ready_);
  }
  /// Lets `time` go by in small steps; \return everything sent meanwhile, nothing of it answered.
  std::vector<Bytes> wait(std::chrono::milliseconds time) {
    std::vector<Bytes> sent;
    for (const MonoTime until = now_ + time; now_ < until; now_ += 5ms)
      if (const Bytes packet = next(); !packet.empty()) sent.push_back(packet);
    return sent;
  }

  MonoTime now_ = mono_from_ns(1'000'000'000'000);
  std::uint32_t sequence_ = 0;
  Bytes first_when_ready_ = kNothing;
  ViscaDialogue dialogue_;
};

TEST_F(ViscaDialogueTest, AsksForThePositionTenTimesASecond) {
  get_ready();
  int questions = 0;
  for (const MonoTime until = now_ + 10s; now_ < until; now_ += 1ms) {
    if (next() != kAskPosition) continue;
    ++questions;
    hear({0x90, 0x50, 0, 0, 0, 7, 0x0F, 0x0F, 0x0F, 0x0F, 0xFF});
  }
  EXPECT_NEAR(questions, 100, 1);
  EXPECT_EQ(dialogue_.position(), (ViscaPosition{7, -1}));
  EXPECT_FALSE(dialogue_.is_lost(now_));
}

TEST_F(ViscaDialogueTest, SendsATargetOnceAndItsSuccessorWithoutWaitingForTheEnd) {
  get_ready();
  want(3);
  EXPECT_EQ(next(), move(3));
  EXPECT_EQ(next(), kNothing);  // its ACK is awaited
  want(4);
  want(5);
  hear(kAck1);
  EXPECT_EQ(next(), move(5));  // newest wins
  hear(kAck2);
  EXPECT_EQ(next(), kNothing);
  EXPECT_EQ(dialogue_.running(), 2);
  hear(kDone1);
  hear(kDone2);
  EXPECT_EQ(dialogue_.running(), 0);
  EXPECT_EQ(next(), kNothing);
}

TEST_F(ViscaDialogueTest, CancelsTheOldestOfTwoMotionsForAThird) {
  get_ready();
  want(1);
  next();
  hear(kAck2);
  want(2);
  next();
  hear(kAck1);
  want(3);
  EXPECT_EQ(next(), cancel(2));
  EXPECT_EQ(next(), kNothing);
  hear(fault(2, 0x04));
  EXPECT_EQ(next(), move(3));
  hear(kAck2);
  EXPECT_EQ(dialogue_.running(), 2);
}

TEST_F(ViscaDialogueTest, TakesNoSocketForTheEndOfTheCommandThatItCancelled) {
  get_ready();
  want(1);
  next();
  hear(kAck1);
  want(2);
  next();
  hear(kAck2);
  want(3);
  EXPECT_EQ(next(), cancel(1));
  hear(fault(1, 0x05));
  EXPECT_EQ(next(), move(3));
}

TEST_F(ViscaDialogueTest, CancelsFirstWhereAMotionIsNotExecutableDuringAnother) {
  get_ready();
  want(1);
  next();
  hear(kAck1);
  want(2);
  EXPECT_EQ(next(), move(2));
  hear(fault(0, 0x41));
  EXPECT_FALSE(dialogue_.is_refused());
  EXPECT_EQ(next(), cancel(1));
  hear(fault(1, 0x04));
  EXPECT_EQ(next(), move(2));
  hear(kAck1);
  want(3);
  EXPECT_EQ(next(), cancel(1));  // it has learned
  hear(fault(1, 0x04));
  EXPECT_EQ(next(), move(3));
}

TEST_F(ViscaDialogueTest, EmptiesBothSocketsWhenTheBufferIsFullForReasonsUnknown) {
  get_ready();
  want(1);
  next();
  hear(fault(0, 0x03));
  EXPECT_EQ(next(), cancel(1));
  hear(fault(1, 0x04));
  EXPECT_EQ(next(), cancel(2));
  hear(fault(2, 0x05));
  EXPECT_EQ(next(), move(1));
  hear(kAck1);
  EXPECT_FALSE(dialogue_.is_refused());
}

TEST_F(ViscaDialogueTest, SaysThatAMotionIsRefusedUntilOneIsAccepted) {
  get_ready();
  want(1);
  next();
  hear(fault(0, 0x41));
  EXPECT_TRUE(dialogue_.is_refused());
  EXPECT_EQ(dialogue_.problem(now_), ViscaProblem::kRefused);
  want(2);  // a frame later
  EXPECT_EQ(next(), kNothing);
  now_ += 500ms;
  EXPECT_EQ(next(), kAskPosition);
  hear(kAtZero);
  EXPECT_TRUE(dialogue_.is_refused());
  EXPECT_EQ(next(), move(2));
  hear(kAck1);
  EXPECT_FALSE(dialogue_.is_refused());
  EXPECT_EQ(dialogue_.problem(now_), ViscaProblem::kNone);
}

TEST_F(ViscaDialogueTest, SendsATargetAgainWhenTheCameraGivesItUpOnItsWay) {
  get_ready();
  want(1);
  next();
  hear(kAck1);
  hear(fault(1, 0x41));
  EXPECT_TRUE(dialogue_.is_refused());
  EXPECT_EQ(dialogue_.running(), 0);
  now_ += 500ms;
  EXPECT_EQ(next(), kAskPosition);
  hear(kAtZero);
  EXPECT_EQ(next(), move(1));
}

TEST_F(ViscaDialogueTest, StopsByCancellingEveryMotionAndThenTheDrive) {
  get_ready();
  want(1);
  next();
  hear(kAck1);
  want(2);
  next();
  hear(kAck2);
  want_stop();
  EXPECT_EQ(next(), cancel(1));
  hear(fault(1, 0x04));
  EXPECT_EQ(next(), cancel(2));
  hear(fault(2, 0x04));
  EXPECT_EQ(next(), kStop);
  hear(kAck1);
  hear(kDone1);
  EXPECT_EQ(next(), kNothing);
  want(2);  // the same target as before is a new order
  EXPECT_EQ(next(), move(2));
}

TEST_F(ViscaDialogueTest, RepeatsWhatGetsNoAnswerAndIsLostAfterASecond) {
  get_ready();
  want(1);
  const std::vector<Bytes> sent = wait(995ms);
  // The position is overdue by then, and goes first.
  EXPECT_EQ(sent, (std::vector<Bytes>{move(1), kAskPosition, kAskPosition, kAskPosition}));
  EXPECT_FALSE(dialogue_.is_lost(now_));
  now_ += 5ms;
  EXPECT_TRUE(dialogue_.is_lost(now_));
  EXPECT_EQ(next(), kNothing);
}

TEST_F(ViscaDialogueTest, IsLostWhenPositionsStopComingThoughMotionsAreAccepted) {
  get_ready();
  for (const MonoTime until = now_ + 3s; now_ < until && !dialogue_.is_lost(now_); now_ += 5ms) {
    want(static_cast<int>(sequence_ % 16));
    const Bytes packet = next();
    if (packet.size() == 15) hear(kAck1);
    if (packet.size() == 3) hear(fault(packet[1] & 0x0F, 0x05));
  }
  EXPECT_TRUE(dialogue_.is_lost(now_));
}

TEST_F(ViscaDialogueTest, SurvivesOneLostAnswerOfEachKind) {
  get_ready();
  want(1);
  EXPECT_EQ(next(), move(1));
  now_ += 250ms;
  EXPECT_EQ(next(), kAskPosition);  // its ACK got lost
  hear(kAtZero);
  EXPECT_EQ(next(), move(1));
  hear(kAck2);
  want(2);
  EXPECT_EQ(next(), move(2));
  hear(kAck1);
  want(3);
  EXPECT_EQ(next(), cancel(2));
  now_ += 250ms;  // the answer got lost
  EXPECT_EQ(next(), cancel(2));
  hear(fault(2, 0x05));
  EXPECT_EQ(next(), kAskPosition);
  now_ += 250ms;
  EXPECT_EQ(next(), kAskPosition);
  hear(kAtZero);
  EXPECT_EQ(next(), move(3));
  hear(kAck2);
  EXPECT_FALSE(dialogue_.is_lost(now_ + 900ms));
}

TEST_F(ViscaDialogueTest, BeginsAnewAfterANetworkChangeAndSendsTheTargetAgain) {
  get_ready();
  want(4);
  next();
  hear(kAck1);
  hear({0x90, 0x38, 0xFF});
  EXPECT_FALSE(dialogue_.is_ready());
  EXPECT_EQ(next(), kAddressSet);
  hear({0x90, 0x38, 0xFF});  // in answer to it
  hear({0x88, 0x30, 0x02, 0xFF});
  EXPECT_EQ(next(), kIfClear);
  hear(kIfClear);
  EXPECT_EQ(next(), kAskPosition);
  hear(kAtZero);
  EXPECT_EQ(next(), move(4));
}

TEST_F(ViscaDialogueTest, HearsItsOwnCameraAlone) {
  get_ready();
  now_ += 100ms;
  EXPECT_EQ(next(), kAskPosition);
  hear({0xA0, 0x50, 0, 0, 0, 5, 0, 0, 0, 5, 0xFF});
  EXPECT_EQ(dialogue_.position(), ViscaPosition{});
  EXPECT_EQ(next(), kNothing);  // still waiting
}

TEST_F(ViscaDialogueTest, NamesWhatIsWrongAtTheStart) {
  dialogue_.begin(now_);
  wait(1000ms);
  EXPECT_EQ(dialogue_.problem(now_), ViscaProblem::kSilent);

  dialogue_.begin(now_);
  next();
  hear({0x12, 0x34, 0x90, 0x77, 0xFF});
  wait(1000ms);
  EXPECT_EQ(dialogue_.problem(now_), ViscaProblem::kUnreadable);

  dialogue_.begin(now_);
  next();
  hear(kAddressSet);  // the echo of a line without cameras
  wait(1000ms);
  EXPECT_EQ(dialogue_.problem(now_), ViscaProblem::kNoSuchCamera);
  EXPECT_EQ(dialogue_.cameras(), 0);

  dialogue_.begin(now_);
  next();
  hear({0x88, 0x30, 0x02, 0xFF});
  next();
  hear(kIfClear);
  EXPECT_EQ(next(), kAskPosition);
  hear(fault(0, 0x41));  // in standby
  wait(1000ms);
  EXPECT_EQ(dialogue_.problem(now_), ViscaProblem::kRefused);
}

class ViscaDialogueZoomTest : public ViscaDialogueTest {
 protected:
  static ViscaOptions with_zoom() {
    ViscaOptions options = ViscaDialogueTest::options();
    options.zoom = 0x123;
    return options;
  }
  void get_to_the_zoom() {
    zooming_.begin(now_);
    next();
    hear({0x88, 0x30, 0x02, 0xFF});
    next();
    hear(kIfClear);
  }
  Bytes next() {
    const auto packet = zooming_.next_packet(now_);
    return packet ? Bytes(packet->bytes().begin(), packet->bytes().end()) : kNothing;
  }
  void hear(const Bytes& bytes) { zooming_.receive(bytes, now_); }
  ViscaDialogue zooming_{with_zoom()};
};

TEST_F(ViscaDialogueZoomTest, SetsTheZoomAndGoesOnWhenItIsReadBack) {
  get_to_the_zoom();
  EXPECT_EQ(next(), (Bytes{0x81, 0x01, 0x04, 0x47, 0, 1, 2, 3, 0xFF}));
  hear(kAck1);
  EXPECT_EQ(next(), kNothing);
  now_ += 100ms;
  EXPECT_EQ(next(), kAskZoom);
  hear({0x90, 0x50, 0, 1, 2, 2, 0xFF});  // close, and still moving
  EXPECT_EQ(next(), kNothing);
  hear(kDone1);
  now_ += 100ms;
  EXPECT_EQ(next(), kAskZoom);
  hear({0x90, 0x50, 0, 1, 2, 4, 0xFF});
  EXPECT_EQ(zooming_.zoom(), 0x124);
  EXPECT_EQ(next(), kAskPosition);
}

TEST_F(ViscaDialogueZoomTest, GoesOnWithoutACompletionWhenTheReadingStays) {
  get_to_the_zoom();
  next();
  hear(kAck1);
  for (int i = 0; i < 2; ++i) {
    now_ += 100ms;
    EXPECT_EQ(next(), kAskZoom);
    hear({0x90, 0x50, 0, 1, 2, 3, 0xFF});
  }
  EXPECT_EQ(next(), kAskPosition);
  EXPECT_EQ(zooming_.running(), 0);
}

TEST_F(ViscaDialogueZoomTest, GivesUpOnALensThatDoesNotArrive) {
  get_to_the_zoom();
  next();
  hear(kAck1);
  hear(kDone1);
  for (const MonoTime until = now_ + 9990ms; now_ < until; now_ += 10ms)
    if (next() == kAskZoom) hear({0x90, 0x50, 0, 0, 0, 0, 0xFF});
  EXPECT_FALSE(zooming_.is_lost(now_));
  now_ += 200ms;
  EXPECT_EQ(next(), kAskZoom);
  hear({0x90, 0x50, 0, 0, 0, 0, 0xFF});
  EXPECT_TRUE(zooming_.is_lost(now_));
  EXPECT_EQ(zooming_.problem(now_), ViscaProblem::kZoom);
}

TEST_F(ViscaDialogueTest, AnswersTheSameHoweverTheBytesAreSplit) {
  std::mt19937 random(7);
  const Bytes line = {0x90, 0x41, 0xFF, 0x03, 0x90, 0x50, 0, 0, 0, 5, 0, 0, 0, 6, 0xFF, 0xFF, 0x90, 0x51, 0xFF};
  get_ready();
  for (int round = 0; round < 500; ++round) {
    want(1 + round % 2);
    ASSERT_EQ(next(), move(1 + round % 2));
    for (std::size_t at = 0; at < line.size();) {
      const std::size_t count = std::min<std::size_t>(line.size() - at, 1 + random() % 6);
      hear(Bytes(line.begin() + static_cast<std::ptrdiff_t>(at),
                 line.begin() + static_cast<std::ptrdiff_t>(at + count)));
      at += count;
    }
    ASSERT_EQ(dialogue_.position(), (ViscaPosition{5, 6}));
    ASSERT_EQ(dialogue_.running(), 0);
    ASSERT_EQ(next(), kNothing);
  }
}

TEST_F(ViscaDialogueTest, WakesUpInTimeForEverythingItHasToDo) {
  get_ready();
  EXPECT_EQ(dialogue_.wake_at(), now_ + 100ms);
  now_ += 100ms;
  EXPECT_EQ(next(), kAskPosition);
  EXPECT_EQ(dialogue_.wake_at(), now_ + 250ms);
  now_ += 250ms;
  EXPECT_EQ(next(), kAskPosition);
  hear(kAtZero);
  want(1);
  EXPECT_LE(dialogue_.wake_at(), now_);
  EXPECT_EQ(next(), move(1));
  hear(fault(0, 0x02));
  EXPECT_LE(dialogue_.wake_at(), now_ + 100ms);
}

Bytes at_zoom(int zoom) {
  return {0x90,
          0x50,
          0,
          static_cast<std::uint8_t>(zoom >> 8),
          static_cast<std::uint8_t>(zoom >> 4 & 15),
          static_cast<std::uint8_t>(zoom & 15),
          0xFF};
}

/// Whose zoom is followed.
class ViscaZoomTest : public ViscaDialogueTest {
 protected:
  ViscaZoomTest()
      : ViscaDialogueTest([] {
          ViscaOptions followed = options();
          followed.zoom_interval = 200ms;
          return followed;
        }()) {
    first_when_ready_ = kAskZoom;
  }

  /// Answers everything that is asked, for `time`. \return  how often the zoom was asked for
  int answer(std::chrono::milliseconds time, int zoom) {
    int asked = 0;
    for (const MonoTime until = now_ + time; now_ < until; now_ += 10ms) {
      const Bytes said = next();
      if (said == kAskPosition) hear(kAtZero);
      if (said == kAskZoom) hear(at_zoom(zoom)), ++asked;
      if (said.size() == move(0).size()) hear(kAck1), hear(kDone1);
    }
    return asked;
  }
};

TEST_F(ViscaZoomTest, IsAskedForItsZoomFiveTimesASecondBesideAllElse) {
  get_ready();
  hear(at_zoom(300));
  int asked = 0;
  for (int i = 0; i < 20; ++i) {
    want(i & 15);
    asked += answer(50ms, 300);
  }
  EXPECT_GE(asked, 4);
  EXPECT_LE(asked, 6);
}

TEST_F(ViscaZoomTest, StandsWhereTwoAnswersAgree) {
  get_ready();
  EXPECT_FALSE(dialogue_.zoom_stand());
  hear(at_zoom(300));
  answer(150ms, 300);
  EXPECT_FALSE(dialogue_.zoom_stand()) << "one answer tells no rest";
  const MonoTime before = now_;
  answer(200ms, 300);
  ASSERT_TRUE(dialogue_.zoom_stand());
  EXPECT_EQ(dialogue_.zoom_stand()->position, 300);
  EXPECT_LT(dialogue_.zoom_stand()->since, before);
  answer(400ms, 301);  // between two steps
  ASSERT_TRUE(dialogue_.zoom_stand());
  EXPECT_EQ(dialogue_.zoom_stand()->position, 300);
  answer(200ms, 340);
  EXPECT_FALSE(dialogue_.zoom_stand()) << "on its way";
  answer(200ms, 360);
  EXPECT_FALSE(dialogue_.zoom_stand()) << "on its way";
  const MonoTime moved = now_;
  answer(400ms, 360);
  ASSERT_TRUE(dialogue_.zoom_stand());
  EXPECT_EQ(dialogue_.zoom_stand()->at(now_), 360);
  EXPECT_TRUE(std::isnan(dialogue_.zoom_stand()->at(moved - 300ms))) << "not of the time before";
  EXPECT_TRUE(std::isnan(dialogue_.zoom_stand()->at(now_ + 2s))) << "not for ever";
  dialogue_.begin(now_);
  EXPECT_FALSE(dialogue_.zoom_stand()) << "of the line before";
}

TEST_F(ViscaDialogueTest, IsNotAskedForAZoomThatNobodyFollows) {
  get_ready();
  for (const Bytes& said : wait(2s)) EXPECT_NE(said, kAskZoom);
}

}  // namespace
}  // namespace ninedot
