#include "drivers/servo/dynamixel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "base/contract.h"

namespace ninedot {
namespace {

// FF FF FD 00 ID LENGTH LENGTH INSTRUCTION PARAMETER... CRC CRC; LENGTH counts what comes after it.
constexpr std::array<std::uint8_t, 4> kHeader{0xFF, 0xFF, 0xFD, 0x00};
constexpr std::size_t kIdAt = 4, kLengthAt = 5, kInstructionAt = 7, kErrorAt = 8, kCrcSize = 2;
constexpr std::size_t kMinLength = 3;  // an instruction and the CRC
constexpr std::uint8_t kRead = 0x02, kWrite = 0x03, kStatus = 0x55, kSyncRead = 0x82, kSyncWrite = 0x83;
constexpr std::uint8_t kBroadcast = 0xFE;
constexpr std::uint8_t kAlert = 0x80;

constexpr int kGoal = 116, kLoad = 126, kPosition = 132, kSupply = 144, kTemperature = 146;
constexpr ServoTable kTable{64, kGoal, kGoal, kTemperature + 1 - kGoal, 11, 3, 4095, 112};
constexpr double kStepsPerTurn = 4096;
constexpr double kSpeedUnit_steps_per_s = 0.229 / 60 * kStepsPerTurn;
constexpr double kMaxSpeed = 32767;  // of the register; 0 would be "as fast as it can"

constexpr std::uint8_t low(int value) noexcept { return static_cast<std::uint8_t>(value & 0xFF); }
constexpr std::uint8_t high(int value) noexcept { return static_cast<std::uint8_t>(value >> 8 & 0xFF); }

/// Parts of a packet, put together. All packets here fit: their largest has 23 bytes, and stuffing adds a third at
/// most.
class Builder {
 public:
  Builder(int id, std::uint8_t instruction) noexcept {
    for (const std::uint8_t byte : kHeader) put(byte);
    for (const std::uint8_t byte : {low(id), std::uint8_t{0}, std::uint8_t{0}, instruction}) put(byte);
  }
  Builder& add(std::uint8_t byte) noexcept {
    put(byte);
    // So that no parameters look like the beginning of a packet.
    const std::size_t n = bytes_.size();
    if (n >= kInstructionAt + 3 && bytes_[n - 3] == 0xFF && bytes_[n - 2] == 0xFF && bytes_[n - 1] == 0xFD) put(0xFD);
    return *this;
  }
  Builder& add_word(int value) noexcept { return add(low(value)).add(high(value)); }
  Builder& add(std::span<const std::uint8_t> bytes) noexcept {
    for (const std::uint8_t byte : bytes) add(byte);
    return *this;
  }
  ServoBytes whole() noexcept {
    const auto length = static_cast<int>(bytes_.size() - kInstructionAt + kCrcSize);
    bytes_[kLengthAt] = low(length);
    bytes_[kLengthAt + 1] = high(length);
    const std::uint16_t crc = dynamixel_crc(bytes_.span());
    put(low(crc));
    put(high(crc));
    return bytes_;
  }

 private:
  void put(std::uint8_t byte) noexcept { EXPECTS(bytes_.try_push_back(byte)); }
  ServoBytes bytes_;
};

ServoBytes little_endian(std::uint32_t value) noexcept {
  ServoBytes bytes;
  for (const unsigned shift : {0U, 8U, 16U, 24U})
    EXPECTS(bytes.try_push_back(static_cast<std::uint8_t>(value >> shift & 0xFFU)));
  return bytes;
}

std::uint32_t number_at(std::span<const std::uint8_t> bytes, int address, std::size_t size) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value << 8U | bytes[static_cast<std::size_t>(address - kGoal) + i];
  return value;
}

}  // namespace

std::uint16_t dynamixel_crc(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= std::uint32_t{byte} << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? crc << 1U ^ 0x8005U : crc << 1U;
  }
  return static_cast<std::uint16_t>(crc & 0xFFFFU);
}

const ServoTable& DynamixelDialect::table() const noexcept { return kTable; }

ServoBytes DynamixelDialect::encode_read(int id, int address, int count) const noexcept {
  return Builder(id, kRead).add_word(address).add_word(count).whole();
}

ServoBytes DynamixelDialect::encode_write(const ServoPart& part, int address) const noexcept {
  return Builder(part.id, kWrite).add_word(address).add(part.bytes).whole();
}

ServoBytes DynamixelDialect::encode_write_both(const ServoPart& pan, const ServoPart& tilt,
                                               int address) const noexcept {
  Builder packet(kBroadcast, kSyncWrite);
  packet.add_word(address).add_word(static_cast<int>(pan.bytes.size()));
  for (const ServoPart& part : {pan, tilt}) packet.add(low(part.id)).add(part.bytes);
  return packet.whole();
}

std::optional<ServoBytes> DynamixelDialect::encode_read_both(int pan_id, int tilt_id, int address,
                                                             int count) const noexcept {
  Builder packet(kBroadcast, kSyncRead);
  return packet.add_word(address).add_word(count).add(low(pan_id)).add(low(tilt_id)).whole();
}

PacketLook DynamixelDialect::look_at(std::span<const std::uint8_t> received) const noexcept {
  using Kind = PacketLook::Kind;
  const std::size_t known = std::min(received.size(), kHeader.size());
  if (!std::equal(kHeader.begin(), kHeader.begin() + static_cast<std::ptrdiff_t>(known), received.begin())) return {};
  if (received.size() < kInstructionAt) return {Kind::kIncomplete, 0};
  const std::size_t length = received[kLengthAt] | std::size_t{received[kLengthAt + 1]} << 8U;
  const std::size_t size = kInstructionAt + length;
  if (length < kMinLength || size > ServoBytes::capacity()) return {};
  if (received.size() < size) return {Kind::kIncomplete, 0};
  const std::uint16_t crc = dynamixel_crc(received.first(size - kCrcSize));
  if (received[size - 2] != low(crc) || received[size - 1] != high(crc)) return {};
  return {Kind::kWhole, size};
}

std::optional<ServoReply> DynamixelDialect::decode(std::span<const std::uint8_t> packet) const noexcept {
  if (packet.size() < kErrorAt + 1 + kCrcSize || packet[kInstructionAt] != kStatus) return std::nullopt;
  ServoReply reply;
  reply.id = packet[kIdAt];
  reply.alarm = (packet[kErrorAt] & kAlert) != 0;
  // The other bits: an instruction that the servo did not take. It shows in what the registers hold.
  const std::size_t end = packet.size() - kCrcSize;
  for (std::size_t i = kErrorAt + 1; i < end; ++i) {
    // Stuffing counts from the instruction on.
    const bool is_stuffed =
        packet[i] == 0xFD && packet[i - 1] == 0xFD && packet[i - 2] == 0xFF && packet[i - 3] == 0xFF;
    if (!is_stuffed) EXPECTS(reply.bytes.try_push_back(packet[i]));
  }
  return reply;
}

ServoBytes DynamixelDialect::encode_goal(int position, double /*steps_per_s*/) const noexcept {
  return little_endian(static_cast<std::uint32_t>(position));
}

ServoBytes DynamixelDialect::encode_speed(double steps_per_s) const noexcept {
  return little_endian(
      static_cast<std::uint32_t>(std::clamp(std::round(steps_per_s / kSpeedUnit_steps_per_s), 1.0, kMaxSpeed)));
}

ServoState DynamixelDialect::decode_state(std::span<const std::uint8_t> bytes) const noexcept {
  EXPECTS(bytes.size() == static_cast<std::size_t>(kTable.state_size));
  ServoState state;
  state.goal = static_cast<std::int32_t>(number_at(bytes, kGoal, 4));
  state.position = static_cast<std::int32_t>(number_at(bytes, kPosition, 4));
  state.load_percent = std::abs(static_cast<std::int16_t>(number_at(bytes, kLoad, 2))) * 0.1;
  state.supply_V = number_at(bytes, kSupply, 2) * 0.1;
  state.temperature_degC = number_at(bytes, kTemperature, 1);
  return state;
}

}  // namespace ninedot
