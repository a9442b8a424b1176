#pragma once
/// Feetech's serial servos: STS (and SMS) with magnetic encoders, 4096 positions in a turn, and SCS with
/// potentiometers, 1024 positions over their range, whose numbers have the high byte first.
///
/// Feetech, "Smart servo communication protocol manual" (packets, check sum) and "STS3215 memory table", and the
/// maker's own library FTServo/SCServo (SMS_STS.h, SCSCL.h): Mode 33 (STS), Torque Enable 40, Goal Position 42, Goal
/// Time 44, Goal Speed 46 (steps/s), Present Position 56, Present Load 60 (0.1 %, bit 10: direction), Present Voltage
/// 62 (0.1 V), Present Temperature 63 (degC).
#include "drivers/servo/servo_dialect.h"

namespace ninedot {

enum class FeetechSeries : std::uint8_t { kSts, kScs };

class FeetechDialect final : public ServoDialect {
 public:
  explicit FeetechDialect(FeetechSeries series) noexcept : series_(series) {}
  const ServoTable& table() const noexcept override;
  ServoBytes encode_read(int id, int address, int count) const noexcept override;
  ServoBytes encode_write(const ServoPart& part, int address) const noexcept override;
  ServoBytes encode_write_both(const ServoPart& pan, const ServoPart& tilt, int address) const noexcept override;
  /// None: SCS and the first STS have no such instruction.
  std::optional<ServoBytes> encode_read_both(int pan_id, int tilt_id, int address, int count) const noexcept override;
  PacketLook look_at(std::span<const std::uint8_t> received) const noexcept override;
  std::optional<ServoReply> decode(std::span<const std::uint8_t> packet) const noexcept override;
  ServoBytes encode_goal(int position, double steps_per_s) const noexcept override;
  ServoBytes encode_speed(double steps_per_s) const noexcept override;
  ServoState decode_state(std::span<const std::uint8_t> bytes) const noexcept override;

 private:
  void add_word(ServoBytes& bytes, int value) const noexcept;
  int word_at(std::span<const std::uint8_t> bytes, int address) const noexcept;

  FeetechSeries series_;
};

}  // namespace ninedot
