#include "drivers/servo/visca_packet.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace ninedot {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Kind = ViscaReply::Kind;

Bytes bytes_of(const ViscaPacket& packet) { return {packet.bytes().begin(), packet.bytes().end()}; }

std::optional<ViscaReply> decode(const Bytes& bytes) { return decode_visca_reply(bytes); }

/// All packets that a stream finds in `bytes`.
std::vector<Bytes> packets_in(ViscaStream& stream, const Bytes& bytes) {
  std::vector<Bytes> packets;
  for (const std::uint8_t byte : bytes)
    if (const auto packet = stream.receive(byte)) packets.emplace_back(packet->begin(), packet->end());
  return packets;
}

TEST(ViscaPacket, WritesTheBytesOfTheManual) {
  EXPECT_EQ(bytes_of(encode_visca_address_set()), (Bytes{0x88, 0x30, 0x01, 0xFF}));
  EXPECT_EQ(bytes_of(encode_visca_if_clear()), (Bytes{0x88, 0x01, 0x00, 0x01, 0xFF}));
  EXPECT_EQ(bytes_of(encode_visca_cancel(1, 2)), (Bytes{0x81, 0x22, 0xFF}));
  EXPECT_EQ(bytes_of(encode_visca_stop(3, {24, 20})), (Bytes{0x83, 0x01, 0x06, 0x01, 0x18, 0x14, 0x03, 0x03, 0xFF}));
  EXPECT_EQ(bytes_of(encode_visca_position_inquiry(7)), (Bytes{0x87, 0x09, 0x06, 0x12, 0xFF}));
  EXPECT_EQ(bytes_of(encode_visca_zoom(1, 0x3FF)), (Bytes{0x81, 0x01, 0x04, 0x47, 0x00, 0x03, 0x0F, 0x0F, 0xFF}));
  EXPECT_EQ(bytes_of(encode_visca_zoom_inquiry(1)), (Bytes{0x81, 0x09, 0x04, 0x47, 0xFF}));
}

TEST(ViscaPacket, WritesThePositionsAtBothEndsOfTheRange) {
  EXPECT_EQ(bytes_of(encode_visca_move(1, {24, 20}, {0x370, -0x12C})),
            (Bytes{0x81, 0x01, 0x06, 0x02, 0x18, 0x14, 0, 3, 7, 0, 0x0F, 0x0E, 0x0D, 4, 0xFF}));
  EXPECT_EQ(bytes_of(encode_visca_move(2, {1, 1}, {-0x370, 0x12C})),
            (Bytes{0x82, 0x01, 0x06, 0x02, 0x01, 0x01, 0x0F, 0x0C, 9, 0, 0, 1, 2, 0x0C, 0xFF}));
}

TEST(ViscaPacketDeathTest, TakesAnAddressOrSpeedOutOfRangeForABug) {
  EXPECT_DEATH(encode_visca_position_inquiry(0), "contract");
  EXPECT_DEATH(encode_visca_position_inquiry(8), "contract");
  EXPECT_DEATH(encode_visca_move(1, {25, 20}, {}), "contract");
  EXPECT_DEATH(encode_visca_stop(1, {24, 0}), "contract");
  EXPECT_DEATH(encode_visca_cancel(1, 0), "contract");
  EXPECT_DEATH(encode_visca_zoom(1, 0x10000), "contract");
}

TEST(ViscaReply, ReadsAckAndCompletionWithAddressAndSocket) {
  const auto ack = decode({0x90, 0x41, 0xFF});
  ASSERT_TRUE(ack);
  EXPECT_EQ(ack->kind, Kind::kAck);
  EXPECT_EQ(ack->address, 1);
  EXPECT_EQ(ack->socket, 1);
  const auto completion = decode({0xF0, 0x52, 0xFF});
  ASSERT_TRUE(completion);
  EXPECT_EQ(completion->kind, Kind::kCompletion);
  EXPECT_EQ(completion->address, 7);
  EXPECT_EQ(completion->socket, 2);
}

TEST(ViscaReply, ReadsEachError) {
  const std::vector<std::pair<std::uint8_t, ViscaFault>> codes = {
      {0x01, ViscaFault::kMessageLength}, {0x02, ViscaFault::kSyntax},   {0x03, ViscaFault::kBufferFull},
      {0x04, ViscaFault::kCancelled},     {0x05, ViscaFault::kNoSocket}, {0x41, ViscaFault::kNotExecutable},
      {0x7E, ViscaFault::kUnknown}};
  for (const auto& [code, fault] : codes) {
    const auto reply = decode({0x90, 0x62, code, 0xFF});
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->kind, Kind::kError);
    EXPECT_EQ(reply->fault, fault);
    EXPECT_EQ(reply->socket, 2);
  }
}

TEST(ViscaReply, ReadsPositionsOnBothSidesOfZero) {
  const auto reply = decode({0x90, 0x50, 0x0F, 0x0C, 9, 0, 0, 1, 2, 0x0C, 0xFF});
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->kind, Kind::kPosition);
  EXPECT_EQ(reply->position, (ViscaPosition{-0x370, 0x12C}));
}

TEST(ViscaReply, ReadsZoomBroadcastsAndNetworkChange) {
  const auto zoom = decode({0x90, 0x50, 0, 3, 0x0F, 0x0F, 0xFF});
  ASSERT_TRUE(zoom);
  EXPECT_EQ(zoom->kind, Kind::kZoom);
  EXPECT_EQ(zoom->zoom, 1023);
  const auto addresses = decode({0x88, 0x30, 0x04, 0xFF});
  ASSERT_TRUE(addresses);
  EXPECT_EQ(addresses->kind, Kind::kAddressSet);
  EXPECT_EQ(addresses->cameras, 3);
  const auto clear = decode({0x88, 0x01, 0x00, 0x01, 0xFF});
  ASSERT_TRUE(clear);
  EXPECT_EQ(clear->kind, Kind::kIfClear);
  const auto change = decode({0xA0, 0x38, 0xFF});
  ASSERT_TRUE(change);
  EXPECT_EQ(change->kind, Kind::kNetworkChange);
  EXPECT_EQ(change->address, 2);
}

TEST(ViscaReply, RefusesWhatNoCameraSends) {
  const std::vector<Bytes> wrong = {
      {},
      {0xFF},
      {0x90, 0xFF},
      {0x90, 0x41},                                   // no end
      {0x80, 0x41, 0xFF},                             // from the controller
      {0x81, 0x41, 0xFF},                             // to a camera
      {0x91, 0x41, 0xFF},                             // not to the controller
      {0x90, 0x41, 0x00, 0xFF},                       // too long for an ACK
      {0x90, 0x60, 0xFF},                             // an error without its code
      {0x90, 0x50, 0, 3, 0x1F, 0x0F, 0xFF},           // more than a nibble
      {0x90, 0x51, 0, 3, 0x0F, 0x0F, 0xFF},           // an answer from a socket
      {0x90, 0x50, 0, 0, 0, 0, 0, 0, 0, 0x20, 0xFF},  // more than a nibble
      {0x90, 0x50, 0, 0, 0, 0, 0, 0, 0, 0xFF},        // one nibble is missing
      {0x90, 0x70, 0xFF},                             // no kind of reply
      {0x88, 0x30, 0x00, 0xFF},                       // addresses begin at 1
      {0x88, 0x30, 0x09, 0xFF},                       // eight cameras
      {0x88, 0x01, 0x00, 0x02, 0xFF},
      {0x90, 0x50, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF},  // 17 bytes
  };
  for (const Bytes& bytes : wrong) EXPECT_FALSE(decode(bytes)) << testing::PrintToString(bytes);
}

TEST(ViscaReply, ReadsBackEveryPositionThatAMoveCanCarry) {
  for (int steps = -32768; steps <= 32767; steps += 13) {
    const ViscaPosition position{static_cast<std::int16_t>(steps), static_cast<std::int16_t>(-1 - steps)};
    const Bytes move = bytes_of(encode_visca_move(1, {}, position));
    Bytes reply = {0x90, 0x50};
    reply.insert(reply.end(), move.begin() + 6, move.end());
    const auto decoded = decode(reply);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->position, position);
  }
}

TEST(ViscaStream, FindsMergedPackets) {
  ViscaStream stream;
  EXPECT_EQ(packets_in(stream, {0x90, 0x41, 0xFF, 0x90, 0x51, 0xFF}),
            (std::vector<Bytes>{{0x90, 0x41, 0xFF}, {0x90, 0x51, 0xFF}}));
  EXPECT_EQ(stream.dropped(), 0U);
}

TEST(ViscaStream, DropsAHalfPacketWhenAnotherBegins) {
  ViscaStream stream;
  EXPECT_EQ(packets_in(stream, {0x90, 0x50, 0x01, 0x90, 0x41, 0xFF}), (std::vector<Bytes>{{0x90, 0x41, 0xFF}}));
  EXPECT_EQ(stream.dropped(), 3U);
}

TEST(ViscaStream, DropsWhatHasNoBeginningOrNoEnd) {
  ViscaStream stream;
  Bytes noise(100, 0x05);
  noise.push_back(0xFF);
  EXPECT_TRUE(packets_in(stream, noise).empty());
  Bytes endless(100, 0x05);
  endless.front() = 0x90;
  endless.push_back(0xFF);
  EXPECT_TRUE(packets_in(stream, endless).empty());
  EXPECT_EQ(packets_in(stream, {0x90, 0x42, 0xFF}), (std::vector<Bytes>{{0x90, 0x42, 0xFF}}));
}

TEST(ViscaStream, TakesSixteenBytesAndNotSeventeen) {
  ViscaStream stream;
  Bytes longest(kMaxViscaPacket, 0x01);
  longest.front() = 0x90;
  longest.back() = 0xFF;
  EXPECT_EQ(packets_in(stream, longest), (std::vector<Bytes>{longest}));
  longest.insert(longest.begin() + 1, 0x01);
  EXPECT_TRUE(packets_in(stream, longest).empty());
}

TEST(ViscaStream, LosesNoPacketBetweenAnyNoiseOfLowBytes) {
  std::mt19937 random(20261121);
  const auto below = [&](unsigned limit) { return static_cast<unsigned>(random() % limit); };
  ViscaStream stream;
  for (int round = 0; round < 2000; ++round) {
    Bytes line;
    std::vector<Bytes> sent;
    for (unsigned i = 0, count = below(5); i < count; ++i) {
      for (unsigned noise = below(20); noise > 0; --noise)
        line.push_back(static_cast<std::uint8_t>(below(5) == 0 ? 0xFF : below(0x80)));
      Bytes packet = {static_cast<std::uint8_t>(0x90 + 0x10 * below(7))};
      for (unsigned more = 1 + below(14); more > 0; --more) packet.push_back(static_cast<std::uint8_t>(below(0x80)));
      packet.push_back(0xFF);
      line.insert(line.end(), packet.begin(), packet.end());
      sent.push_back(packet);
    }
    ASSERT_EQ(packets_in(stream, line), sent) << "round " << round;
  }
}

}  // namespace
}  // namespace ninedot
