/// A packet: one byte for sender and receiver (1000 0rrr from the controller, 1sss 0000 from a camera, 88 for all),
/// a few below 80, FF. Numbers of 16 bits go as four nibbles, the highest first.
#include "drivers/servo/visca_packet.h"

#include <algorithm>
#include <initializer_list>

#include "base/contract.h"

namespace ninedot {
namespace {

// Sony's manual (visca_packet.h): 8x is to camera x, 88 to all, FF ends a packet; numbers go four bits to a byte.
constexpr std::uint8_t kBroadcast = 0x88, kEnd = 0xFF, kFromController = 0x80;
constexpr std::size_t kNibbles = 4;

std::uint8_t to_camera(int address) noexcept {
  EXPECTS(address >= kMinViscaAddress && address <= kMaxViscaAddress);
  return static_cast<std::uint8_t>(kFromController + address);
}

ViscaPacket packet_of(std::initializer_list<std::uint8_t> bytes) noexcept {
  return ViscaPacket(std::span(bytes.begin(), bytes.size()));
}

constexpr std::uint8_t nibble(unsigned number, unsigned place) noexcept {
  return static_cast<std::uint8_t>(number >> (4 * (kNibbles - 1 - place)) & 0x0FU);
}

std::uint8_t checked(int speed, int max) noexcept {
  EXPECTS(speed >= 1 && speed <= max);
  return static_cast<std::uint8_t>(speed);
}

/// Nothing unless each byte is a nibble.
std::optional<std::uint16_t> number_at(std::span<const std::uint8_t> packet, std::size_t at) noexcept {
  unsigned number = 0;
  for (const std::uint8_t byte : packet.subspan(at, kNibbles)) {
    if (byte > 0x0FU) return std::nullopt;
    number = number << 4U | byte;
  }
  return static_cast<std::uint16_t>(number);
}

ViscaFault fault_of(std::uint8_t code) noexcept {
  switch (code) {
    case 0x01:
      return ViscaFault::kMessageLength;
    case 0x02:
      return ViscaFault::kSyntax;
    case 0x03:
      return ViscaFault::kBufferFull;
    case 0x04:
      return ViscaFault::kCancelled;
    case 0x05:
      return ViscaFault::kNoSocket;
    case 0x41:
      return ViscaFault::kNotExecutable;
    default:
      return ViscaFault::kUnknown;
  }
}

std::optional<ViscaReply> decode_broadcast(std::span<const std::uint8_t> packet) noexcept {
  ViscaReply reply;
  // Each camera adds one to the number on its way round; it began as 1.
  if (packet.size() == 4 && packet[1] == 0x30 && packet[2] >= 1 && packet[2] <= kMaxViscaAddress + 1) {
    reply.kind = ViscaReply::Kind::kAddressSet;
    reply.cameras = packet[2] - 1;
    return reply;
  }
  if (packet.size() == 5 && packet[1] == 0x01 && packet[2] == 0x00 && packet[3] == 0x01) {
    reply.kind = ViscaReply::Kind::kIfClear;
    return reply;
  }
  return std::nullopt;
}

/// \param reply  comes with address and socket
std::optional<ViscaReply> decode_inquiry(std::span<const std::uint8_t> packet, ViscaReply reply) noexcept {
  if (reply.socket != 0) return std::nullopt;
  if (packet.size() == 7) {
    const auto zoom = number_at(packet, 2);
    if (!zoom) return std::nullopt;
    reply.kind = ViscaReply::Kind::kZoom;
    reply.zoom = *zoom;
    return reply;
  }
  if (packet.size() == 11) {
    const auto pan = number_at(packet, 2), tilt = number_at(packet, 6);
    if (!pan || !tilt) return std::nullopt;
    reply.kind = ViscaReply::Kind::kPosition;
    reply.position = {static_cast<std::int16_t>(*pan), static_cast<std::int16_t>(*tilt)};
    return reply;
  }
  return std::nullopt;
}

}  // namespace

ViscaPacket::ViscaPacket(std::span<const std::uint8_t> bytes) noexcept : size_(bytes.size() + 1) {
  EXPECTS(!bytes.empty() && size_ <= kMaxViscaPacket);
  std::ranges::copy(bytes, bytes_.begin());
  bytes_[size_ - 1] = kEnd;
}

ViscaPacket encode_visca_address_set() noexcept { return packet_of({kBroadcast, 0x30, 0x01}); }

ViscaPacket encode_visca_if_clear() noexcept { return packet_of({kBroadcast, 0x01, 0x00, 0x01}); }

ViscaPacket encode_visca_cancel(int address, int socket) noexcept {
  EXPECTS(socket >= 1 && socket <= 15);
  return packet_of({to_camera(address), static_cast<std::uint8_t>(0x20 + socket)});
}

ViscaPacket encode_visca_move(int address, const ViscaSpeeds& speeds, const ViscaPosition& position) noexcept {
  const auto pan = static_cast<std::uint16_t>(position.pan_steps);
  const auto tilt = static_cast<std::uint16_t>(position.tilt_steps);
  return packet_of({to_camera(address), 0x01, 0x06, 0x02, checked(speeds.pan, kMaxViscaPanSpeed),
                    checked(speeds.tilt, kMaxViscaTiltSpeed), nibble(pan, 0), nibble(pan, 1), nibble(pan, 2),
                    nibble(pan, 3), nibble(tilt, 0), nibble(tilt, 1), nibble(tilt, 2), nibble(tilt, 3)});
}

ViscaPacket encode_visca_stop(int address, const ViscaSpeeds& speeds) noexcept {
  return packet_of({to_camera(address), 0x01, 0x06, 0x01, checked(speeds.pan, kMaxViscaPanSpeed),
                    checked(speeds.tilt, kMaxViscaTiltSpeed), 0x03, 0x03});
}

ViscaPacket encode_visca_position_inquiry(int address) noexcept {
  return packet_of({to_camera(address), 0x09, 0x06, 0x12});
}

ViscaPacket encode_visca_zoom(int address, int zoom) noexcept {
  EXPECTS(zoom >= 0 && zoom <= 0xFFFF);
  const auto number = static_cast<unsigned>(zoom);
  return packet_of({to_camera(address), 0x01, 0x04, 0x47, nibble(number, 0), nibble(number, 1), nibble(number, 2),
                    nibble(number, 3)});
}

ViscaPacket encode_visca_zoom_inquiry(int address) noexcept {
  return packet_of({to_camera(address), 0x09, 0x04, 0x47});
}

std::optional<ViscaReply> decode_visca_reply(std::span<const std::uint8_t> packet) noexcept {
  if (packet.size() < 3 || packet.size() > kMaxViscaPacket || packet.back() != kEnd) return std::nullopt;
  if (packet[0] == kBroadcast) return decode_broadcast(packet);
  if (packet[0] < 0x90 || packet[0] > 0xF0 || (packet[0] & 0x0FU) != 0) return std::nullopt;
  ViscaReply reply;
  reply.address = (packet[0] >> 4) - 8;
  if (packet.size() == 3 && packet[1] == 0x38) {
    reply.kind = ViscaReply::Kind::kNetworkChange;
    return reply;
  }
  reply.socket = packet[1] & 0x0F;
  switch (packet[1] & 0xF0) {
    case 0x40:
      reply.kind = ViscaReply::Kind::kAck;
      return packet.size() == 3 ? std::optional(reply) : std::nullopt;
    case 0x50:
      reply.kind = ViscaReply::Kind::kCompletion;
      return packet.size() == 3 ? std::optional(reply) : decode_inquiry(packet, reply);
    case 0x60:
      reply.kind = ViscaReply::Kind::kError;
      reply.fault = fault_of(packet[2]);
      return packet.size() == 4 ? std::optional(reply) : std::nullopt;
    default:
      return std::nullopt;
  }
}

std::optional<std::span<const std::uint8_t>> ViscaStream::receive(std::uint8_t byte) noexcept {
  const bool begins = byte >= 0x80 && byte != kEnd;
  // Too long, or cut short by the beginning of another; the FF of something that had no beginning.
  if (begins || size_ == kMaxViscaPacket) {
    dropped_ += size_;
    size_ = 0;
  }
  if (!begins && size_ == 0) {
    ++dropped_;
    return std::nullopt;
  }
  bytes_[size_++] = byte;
  if (byte != kEnd) return std::nullopt;
  const std::size_t size = size_;
  size_ = 0;
  return std::span(bytes_).first(size);
}

}  // namespace ninedot
