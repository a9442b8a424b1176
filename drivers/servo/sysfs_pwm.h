#pragma once
/// Servo pulses by a PWM of the kernel (Documentation/ABI/testing/sysfs-class-pwm). Hardware keeps their time.
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "aim/servo_axis.h"
#include "base/result.h"
#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// One channel: exported and running from construction on, stopped and given back by the destructor.
/// Threads: one at a time for all methods. Constructor and destructor wait for the kernel and for udev.
class SysfsPwm {
 public:
  /// \param chip  the name of the chip's device, where its link /sys/class/pwm/pwmchipN/device points to:
  ///              "fe20c000.pwm", "0-0040". Not its number, which changes with kernels and overlays.
  /// \param root  "/sys/class/pwm"; a test puts a tree of plain files there
  /// Throws DeviceAbsent: no such chip (names those that are there), permission missing; StartupError(kWrongUsage): no
  /// such channel, a period that the chip can't have.
  SysfsPwm(const std::string& root, const std::string& chip, int channel, std::chrono::nanoseconds period,
           std::chrono::nanoseconds pulse);
  ~SysfsPwm();
  SysfsPwm(const SysfsPwm&) = delete;
  SysfsPwm& operator=(const SysfsPwm&) = delete;

  /// Writes one number to the kernel; nothing when it is the one before. A processor's own PWM does not wait; a chip
  /// behind I2C (PCA9685) waits for the bus. Memory: none. \error  kIo with errno
  Result<void> set_pulse(std::chrono::nanoseconds pulse) noexcept;
  /// The one that was set last.
  std::chrono::nanoseconds pulse() const noexcept { return std::chrono::nanoseconds(pulse_ns_); }

 private:
  std::string chip_folder_;
  std::string channel_folder_;
  int channel_;
  FileDescriptor duty_;
  std::int64_t pulse_ns_ = -1;
};

/// What a channel is sending at this moment, because a crash left it running; none: it does not run. Throws as
/// find_pwm_chip does.
std::optional<std::chrono::nanoseconds> running_pulse(const std::string& root, const std::string& chip, int channel);

/// The folder of a chip: "/sys/class/pwm/pwmchip2". Throws as SysfsPwm does.
std::string find_pwm_chip(const std::string& root, const std::string& chip);

/// Says what SysfsPwm would refuse, without touching the channel: throws as it does.
void check_sysfs_pwm(const std::string& root, const std::string& chip, int channel);

struct SysfsPanTiltOptions {
  std::string root = "/sys/class/pwm";
  std::string pan_chip, tilt_chip;
  int pan_channel = 0, tilt_channel = 1;
  std::chrono::nanoseconds period = std::chrono::milliseconds(20);
};

/// Threads: as PanTilt says; `move_to` may wait as SysfsPwm::set_pulse does, twice.
class SysfsPanTilt final : public PanTilt {
 public:
  /// \param at  where the head is taken to be; an axis whose channel still runs is where its pulse says
  SysfsPanTilt(const SysfsPanTiltOptions& options, const ServoAxes& axes, const HeadAngles& at);
  void move_to(const HeadAngles& angles) noexcept override;
  /// A servo stands where its pulse says; nothing is under way that could be ended.
  void stop() noexcept override {}
  /// Waits for nothing, asks nobody.
  HeadState state() const noexcept override { return state_; }

 private:
  const ServoAxes axes_;
  HeadState state_;
  SysfsPwm pan_, tilt_;
};

/// A pulse width [us] as a duration.
inline std::chrono::nanoseconds pulse_from_us(double us) noexcept {
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): wrong below 0 only, and a pulse has a width
  return std::chrono::nanoseconds(static_cast<std::int64_t>(us * 1e3 + 0.5));
}

}  // namespace ninedot
