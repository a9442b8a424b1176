#include "drivers/modbus/rtu_receiver.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/modbus/raw_client.h"

namespace ninedot {
namespace {

using test::Bytes;
using test::operator+;
using test::read_pdu;

constexpr std::uint8_t kUnit = 1;

Bytes rtu_frame(std::uint8_t unit, const Bytes& pdu) {
  Bytes frame = Bytes{unit} + pdu;
  const std::uint16_t crc = modbus_crc(frame);
  return frame + Bytes{static_cast<std::uint8_t>(crc & 0xFFU), static_cast<std::uint8_t>(crc >> 8U)};
}

/// A register read's reply with `count` registers that all say `value`.
Bytes reply_pdu(std::uint8_t count, std::uint8_t value) {
  return Bytes{3, static_cast<std::uint8_t>(2 * count)} + Bytes(2U * count, value);
}

std::optional<Bytes> pdu_of(const std::optional<RtuRequest>& request) {
  if (!request) return std::nullopt;
  return Bytes(request->pdu.begin(), request->pdu.end());
}

TEST(RtuReceiver, TheCheckSumIsTheSpecifications) {
  // MODBUS over Serial Line V1.02, section 6.2.2: 02 07 has the check sum 1241 hex, low byte 41 sent first.
  EXPECT_EQ(modbus_crc(Bytes{0x02, 0x07}), 0x1241);
}

TEST(RtuReceiver, AFrameForUsIsARequest) {
  RtuReceiver receiver(kUnit);
  receiver.receive(rtu_frame(kUnit, read_pdu(0, 10)));
  EXPECT_EQ(pdu_of(receiver.end_of_frame()), read_pdu(0, 10));
  EXPECT_FALSE(receiver.has_fragment());
  EXPECT_EQ(receiver.broken_frames(), 0U);
}

TEST(RtuReceiver, AFrameInPiecesIsARequestOnceItIsWhole) {
  const Bytes frame = rtu_frame(kUnit, read_pdu(0, 10));
  for (std::size_t cut = 1; cut < frame.size(); ++cut) {
    RtuReceiver receiver(kUnit);
    receiver.receive(std::span(frame).first(cut));
    EXPECT_FALSE(receiver.end_of_frame()) << cut;
    EXPECT_TRUE(receiver.has_fragment()) << cut;
    receiver.receive(std::span(frame).subspan(cut));
    EXPECT_EQ(pdu_of(receiver.end_of_frame()), read_pdu(0, 10)) << cut;
    EXPECT_EQ(receiver.broken_frames(), 0U) << cut;
  }
}

TEST(RtuReceiver, OtherUnitsRequestsAndRepliesArePassedOver) {
  RtuReceiver receiver(kUnit);
  receiver.receive(rtu_frame(2, read_pdu(0, 10)));
  EXPECT_FALSE(receiver.end_of_frame());
  receiver.receive(rtu_frame(2, reply_pdu(10, 7)));
  EXPECT_FALSE(receiver.end_of_frame());
  receiver.receive(rtu_frame(2, {0x83, 2}));
  EXPECT_FALSE(receiver.end_of_frame());
  EXPECT_FALSE(receiver.has_fragment());
  EXPECT_EQ(receiver.foreign_frames(), 3U);
  EXPECT_EQ(receiver.broken_frames(), 0U);
}

TEST(RtuReceiver, OurRequestIsFoundBehindForeignTrafficThatCameWithoutASilence) {
  RtuReceiver receiver(kUnit);
  receiver.receive(rtu_frame(2, read_pdu(0, 10)) + rtu_frame(2, reply_pdu(10, kUnit)) +
                   rtu_frame(kUnit, read_pdu(3, 4)));
  EXPECT_EQ(pdu_of(receiver.end_of_frame()), read_pdu(3, 4));
  EXPECT_EQ(receiver.foreign_frames(), 2U);
}

TEST(RtuReceiver, OurRequestIsFoundBehindNoiseAndBehindABrokenFrame) {
  for (const Bytes& noise :
       {Bytes{0xFF}, Bytes{1, 3, 0}, Bytes{1, 3, 0, 0, 0, 10, 0xDE, 0xAD}, Bytes(100, 1), Bytes(200, 3)}) {
    RtuReceiver receiver(kUnit);
    receiver.receive(noise + rtu_frame(kUnit, read_pdu(3, 4)));
    EXPECT_EQ(pdu_of(receiver.end_of_frame()), read_pdu(3, 4)) << noise.size();
    EXPECT_EQ(receiver.broken_frames(), 1U) << noise.size();
  }
}

TEST(RtuReceiver, ARequestWithAnythingBehindItIsTooOldToBeAnswered) {
  RtuReceiver receiver(kUnit);
  receiver.receive(rtu_frame(kUnit, read_pdu(0, 10)) + rtu_frame(2, read_pdu(0, 10)));
  EXPECT_FALSE(receiver.end_of_frame());
  receiver.receive(rtu_frame(kUnit, read_pdu(0, 10)) + rtu_frame(kUnit, read_pdu(7, 1)));
  EXPECT_EQ(pdu_of(receiver.end_of_frame()), read_pdu(7, 1)) << "of two requests the newer one";
}

TEST(RtuReceiver, OurOwnRepliesBroughtBackByAnAdapterAreNoRequests) {
  RtuReceiver receiver(kUnit);
  for (const Bytes& reply : {reply_pdu(1, 0), reply_pdu(125, 9), Bytes{0x83, 2}, Bytes{16, 0, 100, 0, 2}}) {
    receiver.receive(rtu_frame(kUnit, reply));
    EXPECT_FALSE(receiver.end_of_frame());
    EXPECT_FALSE(receiver.has_fragment());
  }
}

TEST(RtuReceiver, UnknownFunctionsAndWrongLengthsAreRequestsThatGetAnException) {
  RtuReceiver receiver(kUnit);
  for (const Bytes& pdu : {Bytes{7}, Bytes{43, 14, 1, 0}, Bytes{3, 0, 0, 0}, Bytes{16, 0, 100, 0, 1, 4, 0, 0}}) {
    receiver.receive(rtu_frame(kUnit, pdu));
    EXPECT_EQ(pdu_of(receiver.end_of_frame()), pdu);
  }
}

TEST(RtuReceiver, ABroadcastIsMarkedAsOne) {
  RtuReceiver receiver(kUnit);
  receiver.receive(rtu_frame(0, {6, 0, 104, 0, 1}));
  const auto request = receiver.end_of_frame();
  ASSERT_TRUE(request);
  EXPECT_TRUE(request->broadcast);
}

TEST(RtuReceiver, AWrongCheckSumIsForgottenAndCounted) {
  RtuReceiver receiver(kUnit);
  Bytes frame = rtu_frame(kUnit, read_pdu(0, 10));
  frame.back() ^= 1U;
  receiver.receive(frame);
  EXPECT_FALSE(receiver.end_of_frame());
  receiver.give_up();
  EXPECT_EQ(receiver.broken_frames(), 1U);
  receiver.receive(rtu_frame(kUnit, read_pdu(0, 10)));
  EXPECT_TRUE(receiver.end_of_frame());
}

TEST(RtuReceiver, AnyNoiseOfAnyLengthIsSurvivedAndTheNextRequestFound) {
  const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::seed_seq seed(name.begin(), name.end());
  std::mt19937 random(seed);
  int swallowed = 0;
  for (int i = 0; i < 2000; ++i) {
    RtuReceiver receiver(kUnit);
    for (unsigned chunk = random() % 4; chunk > 0; --chunk) {
      Bytes noise(random() % 700);
      // Few different values: more bytes that look like the start of a frame for us.
      for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random() % 6 == 0 ? random() : random() % 5);
      receiver.receive(noise);
      (void)receiver.end_of_frame();
    }
    if (random() % 2 == 0) receiver.give_up();
    receiver.receive(rtu_frame(kUnit, read_pdu(3, 4)));
    if (pdu_of(receiver.end_of_frame()) == read_pdu(3, 4)) continue;
    // Among a million places, noise has the right check sum by chance here and there; the repetition must get through.
    ++swallowed;
    receiver.give_up();
    receiver.receive(rtu_frame(kUnit, read_pdu(3, 4)));
    ASSERT_EQ(pdu_of(receiver.end_of_frame()), read_pdu(3, 4)) << "round " << i;
  }
  EXPECT_LE(swallowed, 4);
}

}  // namespace
}  // namespace ninedot
