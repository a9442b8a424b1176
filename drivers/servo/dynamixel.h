#pragma once
/// Robotis' Dynamixel servos of the X series, protocol 2.0.
///
/// Robotis e-Manual: "DYNAMIXEL Protocol 2.0" (packets, byte stuffing, instructions) and its page on the CRC; control
/// table of the XL430-W250, which all of the X series share at these addresses: Operating Mode 11, Torque Enable 64,
/// Hardware Error Status 70, Profile Velocity 112 (0.229 rev/min), Goal Position 116, Present Load 126 (0.1 %; the
/// stronger models tell their current there, in 2.69 mA), Present Position 132, Present Input Voltage 144 (0.1 V),
/// Present Temperature 146 (1 degC). 4096 positions in a turn.
#include "drivers/servo/servo_dialect.h"

namespace ninedot {

/// CRC-16 with the polynomial 0x8005, from 0, highest bit first, nothing inverted. Memory: none. Threads: pure.
std::uint16_t dynamixel_crc(std::span<const std::uint8_t> bytes) noexcept;

class DynamixelDialect final : public ServoDialect {
 public:
  const ServoTable& table() const noexcept override;
  ServoBytes encode_read(int id, int address, int count) const noexcept override;
  ServoBytes encode_write(const ServoPart& part, int address) const noexcept override;
  ServoBytes encode_write_both(const ServoPart& pan, const ServoPart& tilt, int address) const noexcept override;
  std::optional<ServoBytes> encode_read_both(int pan_id, int tilt_id, int address, int count) const noexcept override;
  PacketLook look_at(std::span<const std::uint8_t> received) const noexcept override;
  std::optional<ServoReply> decode(std::span<const std::uint8_t> packet) const noexcept override;
  ServoBytes encode_goal(int position, double steps_per_s) const noexcept override;
  ServoBytes encode_speed(double steps_per_s) const noexcept override;
  ServoState decode_state(std::span<const std::uint8_t> bytes) const noexcept override;
};

}  // namespace ninedot
