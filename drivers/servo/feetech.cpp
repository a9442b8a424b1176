#include "drivers/servo/feetech.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

// FF FF ID LENGTH INSTRUCTION PARAMETER... SUM; LENGTH counts what comes after it. An answer has the servo's error bits
// in the instruction's place.
constexpr std::size_t kIdAt = 2, kLengthAt = 3, kErrorAt = 4;
constexpr std::size_t kMinLength = 2;  // an instruction and the check sum
constexpr std::uint8_t kRead = 0x02, kWrite = 0x03, kSyncWrite = 0x83, kBroadcast = 0xFE;

constexpr int kTorque = 40, kGoal = 42, kPosition = 56, kLoad = 60, kSupply = 62, kTemperature = 63;
constexpr ServoTable kStsTable{kTorque, kGoal, kGoal, kTemperature + 1 - kGoal, 33, 0, 4095, std::nullopt};
// SCS servos have no modes: their turning without end is told by angle limits of 0 (9 to 12), of which this byte is
// one.
constexpr int kNoMode = -1;
constexpr ServoTable kScsTable{kTorque, kGoal, kGoal, kTemperature + 1 - kGoal, kNoMode, 0, 1023, std::nullopt};
constexpr int kSignBit = 0x8000, kLoadMask = 0x3FF;
constexpr double kMaxSpeed = 32767;  // of the register; 0 would be "as fast as it can"

std::uint8_t sum_of(std::span<const std::uint8_t> bytes) noexcept {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes.subspan(kIdAt)) sum += byte;
  return static_cast<std::uint8_t>(~sum & 0xFFU);
}

void put(ServoBytes& bytes, int value) noexcept { EXPECTS(bytes.try_push_back(static_cast<std::uint8_t>(value))); }

ServoBytes begin(int id, std::uint8_t instruction) noexcept {
  ServoBytes bytes;
  for (const int byte : {0xFF, 0xFF, id, 0, int{instruction}}) put(bytes, byte);
  return bytes;
}

ServoBytes whole(ServoBytes bytes) noexcept {
  bytes[kLengthAt] = static_cast<std::uint8_t>(bytes.size() - kLengthAt);
  put(bytes, sum_of(bytes.span()));
  return bytes;
}

}  // namespace

const ServoTable& FeetechDialect::table() const noexcept {
  return series_ == FeetechSeries::kSts ? kStsTable : kScsTable;
}

ServoBytes FeetechDialect::encode_read(int id, int address, int count) const noexcept {
  ServoBytes bytes = begin(id, kRead);
  put(bytes, address);
  put(bytes, count);
  return whole(bytes);
}

ServoBytes FeetechDialect::encode_write(const ServoPart& part, int address) const noexcept {
  ServoBytes bytes = begin(part.id, kWrite);
  put(bytes, address);
  for (const std::uint8_t byte : part.bytes) put(bytes, byte);
  return whole(bytes);
}

ServoBytes FeetechDialect::encode_write_both(const ServoPart& pan, const ServoPart& tilt, int address) const noexcept {
  ServoBytes bytes = begin(kBroadcast, kSyncWrite);
  put(bytes, address);
  put(bytes, static_cast<int>(pan.bytes.size()));
  for (const ServoPart& part : {pan, tilt}) {
    put(bytes, part.id);
    for (const std::uint8_t byte : part.bytes) put(bytes, byte);
  }
  return whole(bytes);
}

std::optional<ServoBytes> FeetechDialect::encode_read_both(int /*pan_id*/, int /*tilt_id*/, int /*address*/,
                                                           int /*count*/) const noexcept {
  return std::nullopt;
}

PacketLook FeetechDialect::look_at(std::span<const std::uint8_t> received) const noexcept {
  using Kind = PacketLook::Kind;
  if (received.empty()) return {Kind::kIncomplete, 0};
  if (received[0] != 0xFF || (received.size() > 1 && received[1] != 0xFF)) return {};
  // No servo has the ID FF: a third FF is the header's, and the first one was noise.
  if (received.size() > kIdAt && received[kIdAt] == 0xFF) return {};
  if (received.size() <= kLengthAt) return {Kind::kIncomplete, 0};
  const std::size_t length = received[kLengthAt], size = kLengthAt + 1 + length;
  if (length < kMinLength || size > ServoBytes::capacity()) return {};
  if (received.size() < size) return {Kind::kIncomplete, 0};
  if (received[size - 1] != sum_of(received.first(size - 1))) return {};
  return {Kind::kWhole, size};
}

std::optional<ServoReply> FeetechDialect::decode(std::span<const std::uint8_t> packet) const noexcept {
  if (packet.size() < kErrorAt + 2 || packet[kIdAt] == kBroadcast) return std::nullopt;
  ServoReply reply;
  reply.id = packet[kIdAt];
  reply.alarm = packet[kErrorAt] != 0;
  for (const std::uint8_t byte : packet.subspan(kErrorAt + 1, packet.size() - kErrorAt - 2)) put(reply.bytes, byte);
  return reply;
}

void FeetechDialect::add_word(ServoBytes& bytes, int value) const noexcept {
  const int low = value & 0xFF, high = value >> 8 & 0xFF;
  put(bytes, series_ == FeetechSeries::kSts ? low : high);
  put(bytes, series_ == FeetechSeries::kSts ? high : low);
}

int FeetechDialect::word_at(std::span<const std::uint8_t> bytes, int address) const noexcept {
  const auto at = static_cast<std::size_t>(address - kGoal);
  const int first = bytes[at], second = bytes[at + 1];
  return series_ == FeetechSeries::kSts ? first | second << 8 : first << 8 | second;
}

ServoBytes FeetechDialect::encode_goal(int position, double steps_per_s) const noexcept {
  ServoBytes bytes;
  add_word(bytes, position);
  add_word(bytes, 0);  // no time of its own: the speed counts
  add_word(bytes, static_cast<int>(std::clamp(std::round(steps_per_s), 1.0, kMaxSpeed)));
  return bytes;
}

ServoBytes FeetechDialect::encode_speed(double /*steps_per_s*/) const noexcept { return {}; }

ServoState FeetechDialect::decode_state(std::span<const std::uint8_t> bytes) const noexcept {
  EXPECTS(bytes.size() == static_cast<std::size_t>(table().state_size));
  // STS: sign and size.
  const auto signed_at = [&](int address) {
    const int word = word_at(bytes, address);
    return (word & kSignBit) != 0 ? -(word & ~kSignBit) : word;
  };
  ServoState state;
  state.goal = signed_at(kGoal);
  state.position = signed_at(kPosition);
  state.load_percent = (word_at(bytes, kLoad) & kLoadMask) * 0.1;
  state.supply_V = bytes[kSupply - kGoal] * 0.1;
  state.temperature_degC = bytes[kTemperature - kGoal];
  return state;
}

}  // namespace ninedot
