#include "drivers/servo/pca9685.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <thread>

#include "base/contract.h"
#include "drivers/posix/late_device.h"

namespace ninedot {
namespace {

// Table 4.
constexpr std::uint8_t kMode1 = 0x00, kMode2 = 0x01, kLed0 = 0x06, kPrescale = 0xFE;
constexpr int kRegistersPerOutput = 4;
// Table 5. ALLCALL stays 0: address 0x70, at which the chip would answer too, is that of usual I2C switches.
constexpr std::uint8_t kRestart = 0x80, kAutoIncrement = 0x20, kSleep = 0x10;
// Table 6: totem pole; OCH = 0: outputs change on STOP; OUTNE = 0: low while OE switches them off.
constexpr std::uint8_t kTotemPole = 0x04;
// 7.3.3: bit 4 of LEDn_OFF_H, stronger than everything else.
constexpr std::uint8_t kFullOff = 0x10;
// Of the 8 bits of MODE1 those that only we change: RESTART is the chip's, too, and EXTCLK, once set, stays until the
// supply goes.
constexpr std::uint8_t kExternalClock = 0x40;
constexpr std::uint8_t kMode1Mask = static_cast<std::uint8_t>(~(kRestart | kExternalClock));
// 7.3.1.1: the oscillator needs 500 us at most.
constexpr std::chrono::microseconds kOscillatorStarts{500};

constexpr std::uint8_t register_of(int channel) noexcept {
  return static_cast<std::uint8_t>(kLed0 + kRegistersPerOutput * channel);
}

}  // namespace

std::optional<int> pca9685::prescale_of(std::chrono::nanoseconds period, double oscillator_hz) noexcept {
  const double prescale = std::round(oscillator_hz * static_cast<double>(period.count()) * 1e-9 / kSteps) - 1;
  if (!(prescale >= kMinPrescale && prescale <= kMaxPrescale)) return std::nullopt;
  return static_cast<int>(prescale);
}

int pca9685::steps_of(double pulse_us, int prescale, double oscillator_hz) noexcept {
  const double steps = std::round(pulse_us * 1e-6 * oscillator_hz / (prescale + 1));
  return static_cast<int>(std::clamp(steps, 1.0, kSteps - 1.0));
}

double pca9685::pulse_us_of(int steps, int prescale, double oscillator_hz) noexcept {
  return steps * (prescale + 1) / oscillator_hz * 1e6;
}

int check_pca9685_period(const Pca9685Options& options) {
  const auto prescale = pca9685::prescale_of(options.period, options.oscillator_hz);
  if (!prescale)
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("a PCA9685 at {:g} Hz has no period of {:g} ms; correct period_ms of [pan_tilt]",
                                   options.oscillator_hz, static_cast<double>(options.period.count()) * 1e-6));
  return *prescale;
}

Pca9685::Pca9685(std::unique_ptr<I2cDevice> chip, const Pca9685Options& options,
                 std::unique_ptr<DigitalOutput> output_enable)
    : chip_(std::move(chip)),
      output_enable_(std::move(output_enable)),
      options_(options),
      prescale_(check_pca9685_period(options)) {
  EXPECTS(options.pan_channel != options.tilt_channel);
  for (const int channel : {options.pan_channel, options.tilt_channel})
    EXPECTS(channel >= 0 && channel < pca9685::kChannels);
  if (const Result<void> done = set_up(); !done)
    throw DeviceAbsent(
        fmt::format("no PCA9685 answers ({}: {}); check its supply, its wires and the address of [pan_tilt]",
                    done.error().text, std::strerror(done.error().os_errno)));
}

Result<void> Pca9685::set_up() noexcept {
  NINEDOT_TRY(const std::uint8_t mode, chip_->read_register(kMode1));
  NINEDOT_TRY(const std::uint8_t prescale, chip_->read_register(kPrescale));
  NINEDOT_TRY(const std::uint8_t outputs, chip_->read_register(kMode2));
  // One that woke up and was not restarted has its outputs off; one that is inverted puts out the rest of the period.
  if ((mode & (kSleep | kRestart)) == 0 && prescale == prescale_ && outputs == kTotemPole) {
    NINEDOT_TRY(pan_steps_, running_steps(options_.pan_channel, options_.pan_range));
    NINEDOT_TRY(tilt_steps_, running_steps(options_.tilt_channel, options_.tilt_range));
  }
  // Then the counting up of registers, which writing an output needs, no old pulse while the period changes, and none
  // when the outputs come back.
  const auto as_it_slept = static_cast<std::uint8_t>((mode & kSleep) | kAutoIncrement);
  if (const Result<void> done = chip_->write_register(kMode1, as_it_slept); !done) return done;
  const auto take_over = [this](int channel, int steps, std::optional<double>& running_us) -> Result<void> {
    if (steps == 0) return write_output(channel, 0);
    running_us = pca9685::pulse_us_of(steps, prescale_, options_.oscillator_hz);
    return {};
  };
  if (const Result<void> done = take_over(options_.pan_channel, pan_steps_, running_.pan); !done) return done;
  if (const Result<void> done = take_over(options_.tilt_channel, tilt_steps_, running_.tilt); !done) return done;
  std::uint8_t awake = mode;
  if (prescale != prescale_ || (mode & kSleep) != 0) {
    // PRE_SCALE is taken while asleep only. A chip that fell asleep with its outputs running sets RESTART.
    if (const Result<void> done = chip_->write_register(kMode1, kSleep | kAutoIncrement); !done) return done;
    if (const Result<void> done = chip_->write_register(kPrescale, static_cast<std::uint8_t>(prescale_)); !done)
      return done;
    NINEDOT_TRY(awake, chip_->read_register(kMode1));
  }
  if (const Result<void> done = chip_->write_register(kMode2, kTotemPole); !done) return done;
  if (const Result<void> done = chip_->write_register(kMode1, kAutoIncrement); !done) return done;
  std::this_thread::sleep_for(kOscillatorStarts);
  // The other channels go on as they were.
  if ((awake & kRestart) != 0)
    if (const Result<void> done = chip_->write_register(kMode1, kRestart | kAutoIncrement); !done) return done;
  if (const Result<void> done = expect_register(kPrescale, 0xFF, static_cast<std::uint8_t>(prescale_)); !done)
    return done;
  return expect_register(kMode1, kMode1Mask, kAutoIncrement);
}

/// \return  0: the channel puts out no pulse that `drive` could have told it.
Result<int> Pca9685::running_steps(int channel, const PulseRange& range) noexcept {
  std::array<std::uint8_t, kRegistersPerOutput> found{};
  for (std::size_t i = 0; i < found.size(); ++i) {
    NINEDOT_TRY(found[i], chip_->read_register(static_cast<std::uint8_t>(register_of(channel) + i)));
  }
  const bool begins_with_the_period = found[0] == 0 && found[1] == 0;
  // Full-off among the upper bits makes this larger than any pulse.
  const int steps = found[2] | found[3] << 8;
  // In steps: the shortest and the longest pulse were rounded as well.
  const bool is_ours = begins_with_the_period &&
                       steps >= pca9685::steps_of(range.min_us, prescale_, options_.oscillator_hz) &&
                       steps <= pca9685::steps_of(range.max_us, prescale_, options_.oscillator_hz);
  return is_ours ? steps : 0;
}

Result<void> Pca9685::write_output(int channel, int steps) noexcept {
  // Up at the beginning of the period, down after so many steps; both in one transfer.
  const std::array<std::uint8_t, kRegistersPerOutput> values{
      0, 0, static_cast<std::uint8_t>(steps & 0xFF), steps == 0 ? kFullOff : static_cast<std::uint8_t>(steps >> 8)};
  return chip_->write_registers(register_of(channel), values);
}

Result<void> Pca9685::drive(const ServoTargets& pulses_us) noexcept {
  const auto drive_one = [&](int channel, double pulse_us, int& steps_now) -> Result<void> {
    const int steps = pca9685::steps_of(pulse_us, prescale_, options_.oscillator_hz);
    if (steps == steps_now) return {};
    Result<void> done = write_output(channel, steps);
    if (done) steps_now = steps;
    return done;
  };
  if (Result<void> done = drive_one(options_.pan_channel, pulses_us.pan, pan_steps_); !done) return done;
  if (Result<void> done = drive_one(options_.tilt_channel, pulses_us.tilt, tilt_steps_); !done) return done;
  if (is_enabled_ || !output_enable_) return {};
  Result<void> done = output_enable_->set(true);
  is_enabled_ = done.has_value();
  return done;
}

Result<void> Pca9685::release() noexcept {
  Result<void> done;
  if (output_enable_) done = output_enable_->set(false);
  is_enabled_ = false;
  pan_steps_ = tilt_steps_ = 0;
  for (const int channel : {options_.pan_channel, options_.tilt_channel})
    if (const Result<void> written = write_output(channel, 0); !written) done = written;
  return done;
}

Result<void> Pca9685::expect_register(std::uint8_t address, std::uint8_t mask, std::uint8_t value) noexcept {
  NINEDOT_TRY(const std::uint8_t found, chip_->read_register(address));
  if ((found & mask) == value) return {};
  return fail(Errc::kIo, "the PCA9685 does not hold what was written: did its supply drop, or is it another chip", EIO);
}

Result<void> Pca9685::expect_output(int channel, int steps) noexcept {
  const std::uint8_t off = static_cast<std::uint8_t>(register_of(channel) + 2);
  if (Result<void> done = expect_register(off, 0xFF, static_cast<std::uint8_t>(steps & 0xFF)); !done) return done;
  return expect_register(static_cast<std::uint8_t>(off + 1), 0xFF,
                         steps == 0 ? kFullOff : static_cast<std::uint8_t>(steps >> 8));
}

Result<ServoReading> Pca9685::look() noexcept {
  Result<void> done = expect_register(kMode1, kMode1Mask, kAutoIncrement);
  if (done) done = expect_register(kPrescale, 0xFF, static_cast<std::uint8_t>(prescale_));
  if (done) done = expect_output(options_.pan_channel, pan_steps_);
  if (done) done = expect_output(options_.tilt_channel, tilt_steps_);
  if (!done) return tl::unexpected<Error>(done.error());
  return ServoReading{};
}

}  // namespace ninedot
