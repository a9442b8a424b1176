#include "config/head_keys.h"

#include <array>
#include <vector>

namespace ninedot {
namespace {

// Both axes have the same keys.
template <HeadAxisConfig PanTiltConfig::*axis>
constexpr auto head_axis_keys(std::string_view table) {
#define AXIS_SLOT(member) [](Config& config) -> ConfigSlot { return &(config.pan_tilt.*axis).member; }
  return std::array{
      ConfigKey{table, "min_deg", "deg", -180, 180, "", "the head is never sent below", AXIS_SLOT(min_deg)},
      ConfigKey{table, "max_deg", "deg", -180, 180, "", "the head is never sent above", AXIS_SLOT(max_deg)},
      ConfigKey{table, "neutral_deg", "deg", -180, 180, "", "where it waits for the first landmark",
                AXIS_SLOT(neutral_deg)},
      ConfigKey{table, "start_deg", "deg", -180, 180, "",
                "where it is when it gets its first pulse, and goes from at its slew rate; heads that know where they "
                "are go from there; none = `neutral_deg`",
                AXIS_SLOT(start_deg)},
      ConfigKey{table, "park_deg", "deg", -180, 180, "", "where it parks; none = `neutral_deg`", AXIS_SLOT(park_deg)},
      ConfigKey{table, "slew_deg_per_s", "deg/s", 0.1, 3600, "",
                "fastest turn; servos with a line of their own are told it, too", AXIS_SLOT(slew_deg_per_s)},
      ConfigKey{table, "acceleration_deg_per_s2", "deg/s^2", 1, 1e5, "",
                "fastest change of the turn; above what the servo can do only makes it lag",
                AXIS_SLOT(acceleration_deg_per_s2)},
      ConfigKey{table, "direction", "", 0, 0, "normal|reversed",
                "`normal`: a longer pulse, or a larger position, turns to the left or upwards; with `visca`: the "
                "camera stands "
                "upright",
                AXIS_SLOT(direction)},
      ConfigKey{table, "centre_us", "us", 200, 5000, "", "pulse at 0 deg", AXIS_SLOT(centre_us)},
      ConfigKey{table, "us_per_deg", "us/deg", 0.1, 1000, "", "change of the pulse", AXIS_SLOT(us_per_deg)},
      ConfigKey{table, "min_us", "us", 200, 5000, "", "no pulse is ever shorter", AXIS_SLOT(min_us)},
      ConfigKey{table, "max_us", "us", 200, 5000, "", "no pulse is ever longer", AXIS_SLOT(max_us)},
      ConfigKey{table, "calibration", "", -1e5, 1e5, "",
                "points `[angle_deg, pulse_us]`, for heads on a serial line `[angle_deg, steps]`, by rising angle; in "
                "place of "
                "direction, centre_us and us_per_deg",
                AXIS_SLOT(calibration)},
      ConfigKey{table, "chip", "", 0, 0, "",
                "`sysfs-pwm`: device of the PWM chip, where /sys/class/pwm/pwmchipN/device points to: `fe20c000.pwm`",
                AXIS_SLOT(chip)},
      ConfigKey{table, "channel", "", 0, 63, "", "`sysfs-pwm`, `pca9685` (0 to 15): channel of the chip",
                AXIS_SLOT(channel)},
      ConfigKey{table, "id", "", 0, 252, "",
                "`dynamixel`, `feetech-sts`, `feetech-scs`: the servo's number on its line", AXIS_SLOT(id)},
      ConfigKey{table, "line", "", 0, 0, "", "`gpio`: a line's name, or chip label and offset `LABEL:OFFSET`",
                AXIS_SLOT(line)},
  };
#undef AXIS_SLOT
}

#define SLOT(member) [](Config& config) -> ConfigSlot { return &config.pan_tilt.member; }

const std::array kKeys{
    ConfigKey{
        "pan_tilt", "driver", "", 0, 0, "none|sysfs-pwm|pca9685|gpio|visca|dynamixel|feetech-sts|feetech-scs|simulated",
        "how the head is moved: PWM of the kernel, a PCA9685 on I2C, pulses on GPIO lines, a camera that speaks VISCA, "
        "smart servos of Robotis or Feetech, not at all; `simulated`: with the servos of a simulated camera's "
        "`[simulation]`, else at once and in memory only",
        SLOT(driver)},
    ConfigKey{"pan_tilt", "follow", "", 0, 0, "",
              "keep the landmark in the middle of the picture from the start on; else stay until a command comes",
              SLOT(follow)},
    ConfigKey{"pan_tilt", "gain", "", 0.01, 1, "",
              "part of a sight's deviation from where the landmark was expected that one frame takes away, at 35 Hz",
              SLOT(gain)},
    ConfigKey{"pan_tilt", "dead_band_deg", "deg", 0, 10, "",
              "a smaller deviation is no reason for a head that stands to move", SLOT(dead_band_deg)},
    ConfigKey{"pan_tilt", "head_delay_ms", "ms", 0, 500, "", "from a command until the head stands there",
              SLOT(head_delay_ms)},
    ConfigKey{"pan_tilt", "coast_ms", "ms", 0, 60000, "",
              "so long a landmark that is out of sight is followed to where it should be by then", SLOT(coast_ms)},
    ConfigKey{"pan_tilt", "search", "", 0, 0, "", "sweep for a landmark that was lost; else stay where it was lost",
              SLOT(search)},
    ConfigKey{"pan_tilt", "search_at_start", "", 0, 0, "", "sweep also before the first landmark has been seen",
              SLOT(search_at_start)},
    ConfigKey{"pan_tilt", "search_deg_per_s", "deg/s", 0.1, 3600, "",
              "the sweep's speed, at most the slew rate: so slow that pictures stay sharp", SLOT(search_deg_per_s)},
    ConfigKey{"pan_tilt", "park_after_s", "s", 0, 1e6, "",
              "so long without a landmark in sight the head parks; 0 = never", SLOT(park_after_s)},
    ConfigKey{"pan_tilt", "park_at_shutdown", "", 0, 0, "", "park before the service ends", SLOT(park_at_shutdown)},
    ConfigKey{"pan_tilt", "landmark", "", 0, 0, "hand-over|nearest|reported|id",
              "which of several the head follows: the same until another is nearer by `hand_over_margin_percent`, the "
              "`nearest`, the one whose pose is `reported`, or that of `landmark_id` alone",
              SLOT(landmark)},
    ConfigKey{"pan_tilt", "landmark_id", "", 0, 65535, "", "of `landmark = \"id\"`", SLOT(landmark_id)},
    ConfigKey{"pan_tilt", "hand_over_margin_percent", "%", 0, 90, "",
              "of the distance, by which another must be nearer, for 0.3 s", SLOT(hand_over_margin_percent)},
    ConfigKey{"pan_tilt", "period_ms", "ms", 5, 40, "", "`sysfs-pwm`, `pca9685`, `gpio`: from pulse to pulse",
              SLOT(period_ms)},
    ConfigKey{"pan_tilt", "pulse_priority", "", 0, 99, "",
              "`gpio`: SCHED_FIFO priority of the thread that makes the pulses; 0 = off", SLOT(pulse_priority)},
    ConfigKey{"pan_tilt", "device", "", 0, 0, "",
              "`visca`, `dynamixel`, `feetech-sts`, `feetech-scs`: serial port; `pca9685`: I2C bus, `/dev/i2c-1`",
              SLOT(device)},
    ConfigKey{"pan_tilt", "baud", "", 0, 4000000, "",
              "`dynamixel`, `feetech-sts`, `feetech-scs`: rate of the line; 0 = the maker's, 57600 and 1000000",
              SLOT(baud)},
    ConfigKey{"pan_tilt", "address", "", -1, 127, "",
              "`visca`: the camera's place in the chain, 1 to 7; `pca9685`: address of the chip, 0x40 to 0x77; -1 = "
              "the first "
              "of these",
              SLOT(address)},
    ConfigKey{
        "pan_tilt", "oscillator_hz", "Hz", 1e6, 5e7, "",
        "`pca9685`: what its oscillator really does; the chip's own is some percent off 25 MHz, and all pulses with it",
        SLOT(oscillator_hz)},
    ConfigKey{
        "pan_tilt", "output_enable", "", 0, 0, "",
        "`pca9685`: GPIO line at its OE pin (low = outputs on), by name or `LABEL:OFFSET`; empty = the pin is wired",
        SLOT(output_enable)},
    ConfigKey{
        "pan_tilt", "when_stopped", "", 0, 0, "release|hold",
        "`pca9685`, `dynamixel`, `feetech-sts`, `feetech-scs`: no pulses and no force while inhibited and after the "
        "end, or hold the place",
        SLOT(when_stopped)},
    ConfigKey{
        "pan_tilt", "zoom", "", -1, 1023, "",
        "`visca`: position of the zoom, set at the start; -1 = left as it is. With other drivers: where the zoom is "
        "locked, of a calibration that knows several positions (`ninedot calibrate zoom`)",
        SLOT(zoom)},
};
#undef SLOT

}  // namespace

std::span<const ConfigKey> head_keys() {
  static const std::vector<ConfigKey> keys = [] {
    std::vector<ConfigKey> all(kKeys.begin(), kKeys.end());
    for (const ConfigKey& key : head_axis_keys<&PanTiltConfig::pan>("pan_tilt.pan")) all.push_back(key);
    for (const ConfigKey& key : head_axis_keys<&PanTiltConfig::tilt>("pan_tilt.tilt")) all.push_back(key);
    return all;
  }();
  return keys;
}

}  // namespace ninedot
