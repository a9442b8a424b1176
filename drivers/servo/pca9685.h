#pragma once
/// NXP's PCA9685, a chip of sixteen pulse outputs on I2C, without a driver of the kernel's.
///
/// NXP, "PCA9685: 16-channel, 12-bit PWM Fm+ I2C-bus LED controller", product data sheet, rev. 4 (16 April 2015):
/// registers 7.3 (table 4), MODE1 7.3.1 and restart 7.3.1.1, MODE2 7.3.2, outputs 7.3.3, PRE_SCALE 7.3.5 (equation 1),
/// the OE pin 7.4.
#include <chrono>
#include <memory>
#include <optional>

#include "drivers/servo/i2c_device.h"
#include "drivers/servo/servo_bus.h"
#include "ports/digital_io.h"

namespace ninedot {

/// Of the pulses that an axis may get; the default is that of [pan_tilt.pan].
struct PulseRange {
  double min_us = 1000, max_us = 2000;
};

struct Pca9685Options {
  int pan_channel = 0, tilt_channel = 1;  ///< 0..15, two different ones (contract)
  std::chrono::nanoseconds period = std::chrono::milliseconds(20);
  double oscillator_hz = 25e6;           ///< the chip's own is 25 MHz, give or take some percent: measure a pulse
  PulseRange pan_range{}, tilt_range{};  ///< a running pulse that is beyond was none of ours
};

namespace pca9685 {

inline constexpr int kChannels = 16;
inline constexpr int kSteps = 4096;                              ///< of a period
inline constexpr int kFirstAddress = 0x40, kLastAddress = 0x77;  ///< of table 4 and 7.1: six pins, 0x40..0x7F
/// [1] PRE_SCALE has 8 bits, and the chip takes nothing below 3 (7.3.5).
inline constexpr int kMinPrescale = 3, kMaxPrescale = 255;  ///< [1]

/// \return  [1] round(oscillator / (4096 * rate)) - 1, equation (1) of 7.3.5. None: no such period with this
/// oscillator. Threads: pure.
std::optional<int> prescale_of(std::chrono::nanoseconds period, double oscillator_hz) noexcept;

/// Pulse [us] in steps of the period that the chip really has: 1..4095. \param prescale  [1]. Threads: pure.
int steps_of(double pulse_us, int prescale, double oscillator_hz) noexcept;

/// \param prescale  [1]. \return  [us] the pulse of so many steps. Threads: pure.
double pulse_us_of(int steps, int prescale, double oscillator_hz) noexcept;

}  // namespace pca9685

/// Throws StartupError(kWrongUsage): no such period with this oscillator. \return  [1] its prescale. Threads: pure.
int check_pca9685_period(const Pca9685Options& options);

/// Two of its outputs: totem pole, not inverted, changing at the end of a transfer, so that no pulse is ever made of
/// the old width's one byte and the new one's other. Sets PRE_SCALE where it is another one, for which the chip sleeps
/// for a moment and all of its outputs pause; the other channels are left as they are.
///
/// Nothing here survives the process but the chip's registers: after a kill the last pulses go on, unless the OE pin is
/// on a GPIO line, which the kernel takes back then. A chip that is found running as this would run it is not stopped:
/// each of the two pulses that an axis may get goes on, and is what `running` tells. Everything else is off until the
/// first `drive`.
/// Threads: as ServoBus says; a transfer takes 0.4 ms at 100 kHz, `look` seven of them, each as long as I2cDevice says
/// where the bus hangs.
class Pca9685 final : public ServoBus {
 public:
  /// \param output_enable  active = outputs on; null: the pin is wired to be on
  /// Throws DeviceAbsent: no chip answers; StartupError(kWrongUsage): no such period.
  Pca9685(std::unique_ptr<I2cDevice> chip, const Pca9685Options& options, std::unique_ptr<DigitalOutput> output_enable);

  Result<void> drive(const ServoTargets& pulses_us) noexcept override;
  /// OE first, which is at once, then the outputs' full-off bits.
  Result<void> release() noexcept override;
  /// No position. Fails when the chip is no longer as it was set up: it forgets everything when its supply drops.
  Result<ServoReading> look() noexcept override;
  RunningTargets running() const noexcept override { return running_; }

 private:
  Result<void> set_up() noexcept;
  Result<int> running_steps(int channel, const PulseRange& range) noexcept;
  Result<void> write_output(int channel, int steps) noexcept;
  Result<void> expect_register(std::uint8_t address, std::uint8_t mask, std::uint8_t value) noexcept;
  Result<void> expect_output(int channel, int steps) noexcept;

  const std::unique_ptr<I2cDevice> chip_;
  const std::unique_ptr<DigitalOutput> output_enable_;
  const Pca9685Options options_;
  const int prescale_;
  int pan_steps_ = 0, tilt_steps_ = 0;  // 0: off
  RunningTargets running_;
  bool is_enabled_ = false;
};

}  // namespace ninedot
