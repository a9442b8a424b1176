#pragma once
/// The bytes of VISCA, the serial protocol of Sony's pan/tilt/zoom cameras: 3 to 16 of them, the last one FF.
///
/// Sony, "EVI-D70/D70P Technical Manual" (A-BS4-100-11), pp. 33-38 and 42: packets, replies, errors. The EVI-D31 speaks
/// the same; its ranges are in visca_evi_d31.h.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace ninedot {

inline constexpr std::size_t kMaxViscaPacket = 16;  ///< [bytes]
inline constexpr int kMinViscaAddress = 1, kMaxViscaAddress = 7;
/// A camera executes two commands at a time, each in a "socket" that its ACK names.
inline constexpr int kViscaSockets = 2;

/// Memory: inside. At least three bytes, the last one FF, except where default-constructed.
class ViscaPacket {
 public:
  ViscaPacket() = default;
  /// \param bytes  1 to 15 of them (contract); the FF is added here
  explicit ViscaPacket(std::span<const std::uint8_t> bytes) noexcept;
  std::span<const std::uint8_t> bytes() const noexcept { return std::span(bytes_).first(size_); }

 private:
  std::array<std::uint8_t, kMaxViscaPacket> bytes_{};
  std::size_t size_ = 0;
};

/// Everything below: \param address  of the camera, 1..7 (contract). Memory: none. Threads: pure.

/// Numbers all cameras of the chain, the nearest first; comes back with the count.
ViscaPacket encode_visca_address_set() noexcept;
/// Empties the command buffers of all cameras and ends what they execute; comes back as it was sent.
ViscaPacket encode_visca_if_clear() noexcept;
/// Ends the command in a socket. \param socket  1..15 (contract)
ViscaPacket encode_visca_cancel(int address, int socket) noexcept;

inline constexpr int kMaxViscaPanSpeed = 24, kMaxViscaTiltSpeed = 20;
/// On an EVI-D31 a pan speed of 1 is 3.3 deg/s, 24 is 80 deg/s; a tilt speed of 1 is 2.5 deg/s, 20 is 50 deg/s.
struct ViscaSpeeds {
  int pan = kMaxViscaPanSpeed;    ///< part of the fastest, 1..24 (contract)
  int tilt = kMaxViscaTiltSpeed;  ///< part of the fastest, 1..20 (contract)
};
struct ViscaPosition {
  std::int16_t pan_steps = 0;   ///< positive to the right
  std::int16_t tilt_steps = 0;  ///< positive upwards
  friend bool operator==(const ViscaPosition&, const ViscaPosition&) = default;
};
/// Pan-tiltDrive AbsolutePosition.
ViscaPacket encode_visca_move(int address, const ViscaSpeeds& speeds, const ViscaPosition& position) noexcept;
/// Pan-tiltDrive Stop: ends a motion by speed. One to a position goes on, unless its command is cancelled.
ViscaPacket encode_visca_stop(int address, const ViscaSpeeds& speeds) noexcept;
/// Pan-tiltPosInq.
ViscaPacket encode_visca_position_inquiry(int address) noexcept;
/// CAM_Zoom Direct. \param zoom  [steps] 0..0xFFFF (contract)
ViscaPacket encode_visca_zoom(int address, int zoom) noexcept;
/// CAM_ZoomPosInq.
ViscaPacket encode_visca_zoom_inquiry(int address) noexcept;

enum class ViscaFault : std::uint8_t {
  kUnknown,
  kMessageLength,  ///< 01
  kSyntax,         ///< 02: not understood, or a value out of range
  kBufferFull,     ///< 03: both sockets are in use
  kCancelled,      ///< 04: the answer to a cancel
  kNoSocket,       ///< 05: nothing was there to cancel
  kNotExecutable,  ///< 41: not in this state
};

struct ViscaReply {
  enum class Kind : std::uint8_t {
    kAddressSet,     ///< `cameras`
    kIfClear,        ///< the broadcast has been round the chain
    kAck,            ///< `socket`: the command runs there
    kCompletion,     ///< `socket`: the command has been executed
    kPosition,       ///< `position`
    kZoom,           ///< `zoom`
    kError,          ///< `fault`, `socket`
    kNetworkChange,  ///< a camera was switched on, or the chain has changed: addresses must be set anew
  };
  Kind kind = Kind::kAck;
  int address = 0;  ///< of the sender, 1..7; 0 for a broadcast
  int socket = 0;   ///< 0..15
  ViscaFault fault = ViscaFault::kUnknown;
  int cameras = 0;  ///< in the chain
  ViscaPosition position;
  int zoom = 0;  ///< [steps]
};

/// \param packet  with its FF
/// \return  nothing for what no camera sends in answer to the packets above. Memory: none. Threads: pure.
std::optional<ViscaReply> decode_visca_reply(std::span<const std::uint8_t> packet) noexcept;

/// Finds the packets in what a line delivers, however it was cut or merged. Everything between two packets is dropped:
/// a byte of 80..FE begins one (no other byte of a camera's answers has its top bit set), FF ends it.
/// Memory: inside. Threads: one at a time for all methods; nothing waits.
class ViscaStream {
 public:
  /// \return  a packet that this byte ends, FF included; it stays until the next call
  std::optional<std::span<const std::uint8_t>> receive(std::uint8_t byte) noexcept;
  /// Forgets a packet that has begun.
  void reset() noexcept { size_ = 0; }
  /// Bytes that belonged to no packet.
  std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  std::array<std::uint8_t, kMaxViscaPacket> bytes_{};
  std::size_t size_ = 0;  // 0: no packet has begun
  std::uint64_t dropped_ = 0;
};

}  // namespace ninedot
