#pragma once
/// Two smart servos on one half-duplex line, which tell where they are.
#include <chrono>
#include <memory>
#include <string>

#include "drivers/servo/half_duplex_line.h"
#include "drivers/servo/servo_bus.h"

namespace ninedot {

struct SmartServoOptions {
  std::string device;           ///< serial port: "/dev/ttyUSB0", or better a name below /dev/serial/by-id
  int baud = 1000000;           ///< of kServoBaudRates
  int pan_id = 1, tilt_id = 2;  ///< 0..252, two different ones (contract)
  double pan_steps_per_s = 1000, tilt_steps_per_s = 1000;  ///< [steps/s] the servos' own limit of their speed
  /// For one answer. 32 bytes take 6 ms at 57600 baud, and an FTDI adapter keeps them for 16 ms.
  std::chrono::milliseconds reply_timeout{40};
  /// A servo whose partner does not answer, or reports an error, is released: no head can be made of it, and what stops
  /// the head would not reach it.
  bool lone_lets_go = true;
};

/// Every write is read back, since an answer may get lost as well as what it answers; every transfer has three
/// attempts. So each method waits for at most three times the reply time-out for each thing it asks, some of them two
/// for each servo.
///
/// After a kill the servos hold the goal that they were told last: nothing outside of them ends that but their supply.
class SmartServos final : public ServoBus {
 public:
  static constexpr int kAttempts = 3;
  /// From one look whether the servos are under force still to the next. A servo that has lost its supply for a moment
  /// forgets it, and hangs.
  static constexpr std::chrono::milliseconds kTorqueInterval{1000};

  /// Sets the servos' own speed limit; they are not under force from this.
  /// \param dialect  not null (contract)
  /// Throws DeviceAbsent, one line that says what to do: the port can't be opened, a servo does not answer or reports
  /// an error; StartupError(kWrongUsage): this is no serial port, it does not have the rate, a servo is in another
  /// mode.
  SmartServos(const SmartServoOptions& options, std::unique_ptr<const ServoDialect> dialect);

  Result<void> drive(const ServoTargets& steps) noexcept override;
  Result<void> release() noexcept override;
  /// Sends a goal again that a servo did not hear.
  Result<ServoReading> look() noexcept override;

 private:
  struct Both {
    ServoBytes pan, tilt;
  };

  void set_up(int id, double steps_per_s);
  Result<ServoReply> ask(const ServoBytes& packet, int id, std::size_t count) noexcept;
  Result<ServoBytes> read(int id, int address, int count) noexcept;
  Result<void> write(int id, int address, std::span<const std::uint8_t> bytes) noexcept;
  Result<Both> read_both(int address, int count) noexcept;
  Result<bool> collect(const ServoBytes& packet, std::size_t count, Both& both) noexcept;
  Result<void> set_torque(int id, bool on) noexcept;
  Result<void> send_goals() noexcept;
  Result<void> check_torque() noexcept;

  const SmartServoOptions options_;
  const std::unique_ptr<const ServoDialect> dialect_;
  HalfDuplexLine line_;
  int pan_goal_ = 0, tilt_goal_ = 0;  // [steps]
  bool is_driven_ = false;
  int unheard_goals_ = 0;  // in a row
  MonoTime torque_at_{};
};

/// Opens the port and closes it again, without a word to the servos. Throws as SmartServos does. Threads: any; at
/// start-up.
void check_servo_port(const std::string& device, int baud);

}  // namespace ninedot
