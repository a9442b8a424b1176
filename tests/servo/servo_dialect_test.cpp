#include "drivers/servo/servo_dialect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "drivers/servo/dynamixel.h"
#include "drivers/servo/feetech.h"

namespace ninedot {
namespace {

using Bytes = std::vector<int>;
using Raw = std::vector<std::uint8_t>;
using Kind = PacketLook::Kind;

Bytes bytes_of(const ServoBytes& bytes) { return {bytes.span().begin(), bytes.span().end()}; }
Raw raw(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

// The packets below stand in the makers' manuals as examples.
const DynamixelDialect dynamixel;
const Bytes kDynamixelStatus{0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x08, 0x00, 0x55, 0x00, 0xA6, 0x00, 0x00, 0x00, 0x8C, 0xC0};
const FeetechDialect sts(FeetechSeries::kSts), scs(FeetechSeries::kScs);
const Bytes kFeetechStatus{0xFF, 0xFF, 0x01, 0x04, 0x00, 0x18, 0x05, 0xDD};

TEST(Dynamixel, PacketsAreThoseOfTheManual) {
  EXPECT_EQ(bytes_of(dynamixel.encode_read(1, 132, 4)),
            (Bytes{0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x02, 0x84, 0x00, 0x04, 0x00, 0x1D, 0x15}));
  const Raw goal{0x00, 0x02, 0x00, 0x00};
  EXPECT_EQ(bytes_of(dynamixel.encode_write({1, goal}, 116)),
            (Bytes{0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x09, 0x00, 0x03, 0x74, 0x00, 0x00, 0x02, 0x00, 0x00, 0xCA, 0x89}));
  const auto both = dynamixel.encode_read_both(1, 2, 132, 4);
  ASSERT_TRUE(both);
  EXPECT_EQ(bytes_of(*both),
            (Bytes{0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA}));
  const Raw pan{0x96, 0x00, 0x00, 0x00}, tilt{0xAA, 0x00, 0x00, 0x00};
  EXPECT_EQ(bytes_of(dynamixel.encode_write_both({1, pan}, {2, tilt}, 116)),
            (Bytes{0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x11, 0x00, 0x83, 0x74, 0x00, 0x04, 0x00,
                   0x01, 0x96, 0x00, 0x00, 0x00, 0x02, 0xAA, 0x00, 0x00, 0x00, 0x82, 0x87}));
}

TEST(Dynamixel, ReadsTheManualsAnswer) {
  const Raw packet = raw(kDynamixelStatus);
  ASSERT_EQ(dynamixel.look_at(packet).kind, Kind::kWhole);
  const auto reply = dynamixel.decode(packet);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->id, 1);
  EXPECT_FALSE(reply->alarm);
  EXPECT_EQ(bytes_of(reply->bytes), (Bytes{0xA6, 0, 0, 0})) << "position 166";
}

TEST(Dynamixel, AnInstructionIsNoAnswer) {
  const ServoBytes echo = dynamixel.encode_read(1, 132, 4);
  EXPECT_EQ(dynamixel.look_at(echo.span()).kind, Kind::kWhole);
  EXPECT_FALSE(dynamixel.decode(echo.span()));
}

TEST(Dynamixel, StuffsAndUnstuffsWhatLooksLikeAHeader) {
  // A position of -515 reads FD FD FF FF, one of 0x00FDFFFF reads FF FF FD 00.
  const Raw header{0xFF, 0xFF, 0xFD, 0x00};
  const Bytes packet = bytes_of(dynamixel.encode_write({1, header}, 116));
  EXPECT_EQ(Bytes(packet.begin() + 10, packet.end() - 2), (Bytes{0xFF, 0xFF, 0xFD, 0xFD, 0x00}));
  EXPECT_EQ(packet[5], 10) << "the length counts the stuffing";
  Raw status = raw({0xFF, 0xFF, 0xFD, 0x00, 0x01, 9, 0x00, 0x55, 0x00, 0xFF, 0xFF, 0xFD, 0xFD, 0x00});
  const std::uint16_t crc = dynamixel_crc(status);
  status.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  status.push_back(static_cast<std::uint8_t>(crc >> 8U));
  const auto reply = dynamixel.decode(status);
  ASSERT_TRUE(reply);
  EXPECT_EQ(bytes_of(reply->bytes), (Bytes{0xFF, 0xFF, 0xFD, 0x00}));
}

TEST(Dynamixel, TellsAnAlarm) {
  Raw packet = raw(kDynamixelStatus);
  packet[8] = 0x80;
  EXPECT_TRUE(dynamixel.decode(packet)->alarm);
}

TEST(Dynamixel, ReadsSignsAndUnits) {
  Raw state(31, 0);
  const auto put = [&](std::size_t address, const Raw& bytes) {
    std::copy(bytes.begin(), bytes.end(), state.begin() + static_cast<std::ptrdiff_t>(address - 116));
  };
  put(116, {0x34, 0x12, 0, 0});
  put(126, {0x38, 0xFF});              // -200
  put(132, {0xF6, 0xFF, 0xFF, 0xFF});  // -10
  put(144, {121, 0});
  put(146, {43});
  const ServoState found = dynamixel.decode_state(state);
  EXPECT_EQ(found.goal, 0x1234);
  EXPECT_EQ(found.position, -10);
  EXPECT_NEAR(found.load_percent, 20, 1e-9);
  EXPECT_NEAR(found.supply_V, 12.1, 1e-9);
  EXPECT_EQ(found.temperature_degC, 43);
}

TEST(Dynamixel, SpeedIsInRevolutionsPerMinute) {
  // 100 units of 0.229 rev/min are 137.4 deg/s.
  EXPECT_EQ(bytes_of(dynamixel.encode_speed(137.4 * 4096 / 360)), (Bytes{100, 0, 0, 0}));
  EXPECT_EQ(bytes_of(dynamixel.encode_speed(0.001)), (Bytes{1, 0, 0, 0})) << "0 would be without limit";
}

TEST(Feetech, PacketsAreThoseOfTheManual) {
  EXPECT_EQ(bytes_of(sts.encode_read(1, 56, 2)), (Bytes{0xFF, 0xFF, 0x01, 0x04, 0x02, 0x38, 0x02, 0xBE}));
  const Raw goal{0x00, 0x08, 0x00, 0x00, 0xE8, 0x03};
  EXPECT_EQ(bytes_of(sts.encode_write({1, goal}, 42)),
            (Bytes{0xFF, 0xFF, 0x01, 0x09, 0x03, 0x2A, 0x00, 0x08, 0x00, 0x00, 0xE8, 0x03, 0xD5}));
  const Bytes both = bytes_of(sts.encode_write_both({1, goal}, {2, goal}, 42));
  EXPECT_EQ(Bytes(both.begin(), both.begin() + 8), (Bytes{0xFF, 0xFF, 0xFE, 0x12, 0x83, 0x2A, 0x06, 0x01}));
  EXPECT_EQ(sts.encode_read_both(1, 2, 56, 2), std::nullopt);
}

TEST(Feetech, GoalIsPositionTimeAndSpeedInTheSeriesOrderOfBytes) {
  EXPECT_EQ(bytes_of(sts.encode_goal(0x0812, 1000)), (Bytes{0x12, 0x08, 0, 0, 0xE8, 0x03}));
  EXPECT_EQ(bytes_of(scs.encode_goal(0x0312, 1000)), (Bytes{0x03, 0x12, 0, 0, 0x03, 0xE8}));
  EXPECT_EQ(bytes_of(sts.encode_goal(0, 0)), (Bytes{0, 0, 0, 0, 1, 0})) << "0 would be without limit";
}

TEST(Feetech, ReadsTheManualsAnswerSignsAndUnits) {
  const Raw packet = raw(kFeetechStatus);
  ASSERT_EQ(sts.look_at(packet).kind, Kind::kWhole);
  const auto reply = sts.decode(packet);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->id, 1);
  EXPECT_EQ(bytes_of(reply->bytes), (Bytes{0x18, 0x05}));
  Raw alarm = packet;
  alarm[4] = 0x20;
  EXPECT_TRUE(sts.decode(alarm)->alarm);
  Raw state(22, 0);
  state[0] = 0x34, state[1] = 0x12;    // 42: goal
  state[14] = 0x0A, state[15] = 0x80;  // 56: -10
  state[18] = 0xC8, state[19] = 0x04;  // 60: 20 %, the other way
  state[20] = 74, state[21] = 40;
  const ServoState found = sts.decode_state(state);
  EXPECT_EQ(found.goal, 0x1234);
  EXPECT_EQ(found.position, -10);
  EXPECT_NEAR(found.load_percent, 20, 1e-9);
  EXPECT_NEAR(found.supply_V, 7.4, 1e-9);
  EXPECT_EQ(found.temperature_degC, 40);
  std::swap(state[14], state[15]);
  state[15] = 0x0A, state[14] = 0x02;
  EXPECT_EQ(scs.decode_state(state).position, 0x020A);
}

/// Both: every prefix of a packet may become one, no packet with a wrong bit is one, and noise before it is noise.
template <typename Dialect>
void keeps_to_the_laws(const Dialect& dialect, const Raw& packet) {
  for (std::size_t size = 0; size < packet.size(); ++size)
    EXPECT_EQ(dialect.look_at(std::span(packet).first(size)).kind, Kind::kIncomplete) << size;
  Raw longer(packet.size() + 1, 0x55);
  std::ranges::copy(packet, longer.begin());
  EXPECT_EQ(dialect.look_at(longer).kind, Kind::kWhole);
  EXPECT_EQ(dialect.look_at(longer).size, packet.size());
  for (std::size_t bit = 0; bit < packet.size() * 8; ++bit) {
    Raw spoilt = packet;
    spoilt[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_NE(dialect.look_at(spoilt).kind, Kind::kWhole) << "bit " << bit;
  }
  for (int byte = 0; byte < 256; ++byte) {
    if (byte == packet[0]) continue;
    EXPECT_EQ(dialect.look_at(Raw{static_cast<std::uint8_t>(byte)}).kind, Kind::kNone);
  }
}

TEST(ServoDialects, TellWholePacketsFromPartsAndFromNoise) {
  keeps_to_the_laws(dynamixel, raw(kDynamixelStatus));
  keeps_to_the_laws(sts, raw(kFeetechStatus));
  EXPECT_EQ(sts.look_at(Raw{0xFF, 0xFF, 0xFF}).kind, Kind::kNone) << "the header begins one byte later";
  EXPECT_EQ(dynamixel.look_at(Raw{0xFF, 0xFF, 0xFF}).kind, Kind::kNone);
  EXPECT_EQ(dynamixel.look_at(Raw{0xFF, 0xFF, 0xFD, 0x00, 1, 0xFF, 0xFF}).kind, Kind::kNone) << "no packet is so long";
}

}  // namespace
}  // namespace ninedot
