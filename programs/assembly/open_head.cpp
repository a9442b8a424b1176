#include "programs/assembly/open_head.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "base/contract.h"
#include "base/startup_error.h"
#include "base/units.h"
#include "config/head_options.h"
#include "drivers/gpio/gpio_lines.h"
#include "drivers/servo/bus_pan_tilt.h"
#include "drivers/servo/dynamixel.h"
#include "drivers/servo/feetech.h"
#include "drivers/servo/gpio_pan_tilt.h"
#include "drivers/servo/i2c_device.h"
#include "drivers/servo/late_pan_tilt.h"
#include "drivers/servo/pca9685.h"
#include "drivers/servo/powered_head.h"
#include "drivers/servo/simulated_pan_tilt.h"
#include "drivers/servo/smart_servos.h"
#include "drivers/servo/sysfs_pwm.h"
#include "drivers/servo/visca_pan_tilt.h"
#include "programs/assembly/motion_options.h"
#include "programs/assembly/simulation_options.h"
#include "programs/assembly/zoom_choice.h"

namespace ninedot {
namespace {

constexpr const char* kPwmRoot = "/sys/class/pwm";
// Seven registers are read each time, 3 ms at 100 kHz; a chip that was reset is noticed in a tenth of a second.
constexpr std::chrono::milliseconds kPca9685LookInterval{100};
// Of a frame at 35 Hz two thirds; one question and its two answers take 3 ms at 1 Mbaud, 20 at 57600.
constexpr std::chrono::milliseconds kSmartLookInterval{20};
// A question with its answer takes the line for 15 ms, and the camera for a field of its picture: a twelfth of the
// time.
constexpr std::chrono::milliseconds kZoomInterval{200};

std::chrono::nanoseconds period_of(const PanTiltConfig& config) {
  return std::chrono::nanoseconds(std::llround(config.period_ms * 1e6));
}

std::unique_ptr<PanTilt> open_sysfs_pwm(const PanTiltConfig& config, const HeadAngles& at) {
  SysfsPanTiltOptions options;
  options.root = kPwmRoot;
  options.pan_chip = config.pan.chip;
  options.pan_channel = config.pan.channel;
  options.tilt_chip = config.tilt.chip;
  options.tilt_channel = config.tilt.channel;
  options.period = period_of(config);
  return std::make_unique<SysfsPanTilt>(options, servo_axes(config), at);
}

std::unique_ptr<PanTilt> open_gpio(const PanTiltConfig& config, const HeadAngles& at, std::string& description) {
  auto pan = open_gpio_output({config.pan.line}), tilt = open_gpio_output({config.tilt.line});
  const GpioPanTiltOptions options{period_of(config), config.pulse_priority};
  auto head = std::make_unique<GpioPanTilt>(std::move(pan), std::move(tilt), options, servo_axes(config), at);
  if (const Result<void>& realtime = head->realtime(); !realtime)
    description += fmt::format(", pulses without real-time priority ({}): allow it with LimitRTPRIO= or `ulimit -r`",
                               std::strerror(realtime.error().os_errno));
  return head;
}

std::unique_ptr<PanTilt> open_visca(const PanTiltConfig& config, bool follows_zoom, std::string& description) {
  ViscaOptions options;
  if (follows_zoom) options.zoom_interval = kZoomInterval;
  options.device = config.device;
  if (config.address > 0) options.address = config.address;
  if (config.zoom >= 0) options.zoom = config.zoom;
  auto head = std::make_unique<ViscaPanTilt>(options, servo_axes(config));
  if (const auto zoom = head->zoom()) description += fmt::format(", zoom {}", *zoom);
  return head;
}

bool is_smart(const PanTiltConfig& config) {
  return config.driver == "dynamixel" || config.driver == "feetech-sts" || config.driver == "feetech-scs";
}

/// Heads that have a line of their own, and open it again themselves when it was lost.
bool is_on_a_bus(const PanTiltConfig& config) {
  return config.driver == "visca" || config.driver == "pca9685" || is_smart(config);
}

BusPanTiltOptions bus_options(const PanTiltConfig& config, std::chrono::milliseconds look_interval) {
  BusPanTiltOptions options;
  options.when_stopped = config.when_stopped == "hold" ? WhenStopped::kHold : WhenStopped::kRelease;
  options.look_interval = look_interval;
  return options;
}

Pca9685Options pca9685_options(const PanTiltConfig& config) {
  return {config.pan.channel,
          config.tilt.channel,
          period_of(config),
          config.oscillator_hz,
          {config.pan.min_us, config.pan.max_us},
          {config.tilt.min_us, config.tilt.max_us}};
}

std::unique_ptr<PanTilt> open_pca9685(const PanTiltConfig& config, const HeadAngles& at) {
  const auto open = [config]() -> std::unique_ptr<ServoBus> {
    // The chip first: its line switches on what it puts out.
    auto chip = open_i2c_device(config.device, config.address < 0 ? pca9685::kFirstAddress : config.address);
    std::unique_ptr<DigitalOutput> output_enable;
    if (!config.output_enable.empty()) output_enable = open_gpio_output({config.output_enable, true});
    return std::make_unique<Pca9685>(std::move(chip), pca9685_options(config), std::move(output_enable));
  };
  return std::make_unique<BusPanTilt>(open, bus_options(config, kPca9685LookInterval), servo_axes(config), at);
}

SmartServoOptions smart_servo_options(const PanTiltConfig& config) {
  SmartServoOptions options;
  options.device = config.device;
  // As they leave the factory: Robotis e-Manual, XL430-W250, Baud Rate 8; Feetech, STS3215 memory table, address 6.
  options.baud = config.baud != 0 ? config.baud : config.driver == "dynamixel" ? 57600 : 1000000;
  options.pan_id = config.pan.id;
  options.tilt_id = config.tilt.id;
  options.lone_lets_go = config.when_stopped != "hold";
  const ServoAxes axes = servo_axes(config);
  const auto steps_per_s = [](const ServoAxis& axis, const HeadAxisConfig& own) {
    const double a = axis.output_at(own.min_deg * kRadPerDeg).value, b = axis.output_at(own.max_deg * kRadPerDeg).value;
    return std::abs((b - a) / (own.max_deg - own.min_deg)) * own.slew_deg_per_s;
  };
  options.pan_steps_per_s = steps_per_s(axes.pan, config.pan);
  options.tilt_steps_per_s = steps_per_s(axes.tilt, config.tilt);
  return options;
}

std::unique_ptr<PanTilt> open_smart_servos(const PanTiltConfig& config, const HeadAngles& at,
                                           std::string& description) {
  const auto open = [config, options = smart_servo_options(config)]() -> std::unique_ptr<ServoBus> {
    std::unique_ptr<const ServoDialect> dialect;
    if (config.driver == "dynamixel")
      dialect = std::make_unique<DynamixelDialect>();
    else
      dialect =
          std::make_unique<FeetechDialect>(config.driver == "feetech-sts" ? FeetechSeries::kSts : FeetechSeries::kScs);
    return std::make_unique<SmartServos>(options, std::move(dialect));
  };
  auto head = std::make_unique<BusPanTilt>(open, bus_options(config, kSmartLookInterval), servo_axes(config), at);
  const ServoHealth health = head->state().servos;
  description += fmt::format(", {:.1f} V, {:.0f} degC, load {:.0f} %", health.supply_V, health.temperature_degC,
                             health.load_percent);
  return head;
}

std::unique_ptr<PanTilt> open_servos(const PanTiltConfig& config, const std::shared_ptr<HeadLine>& head_line,
                                     bool follows_zoom, const HeadAngles& at, std::string& description) {
  if (config.driver == "sysfs-pwm") return open_sysfs_pwm(config, at);
  if (config.driver == "gpio") return open_gpio(config, at, description);
  if (config.driver == "visca") return open_visca(config, follows_zoom, description);
  if (config.driver == "pca9685") return open_pca9685(config, at);
  if (is_smart(config)) return open_smart_servos(config, at, description);
  EXPECTS(config.driver == "simulated");
  if (head_line != nullptr) return std::make_unique<SimulatedHead>(head_line, machine_clock(), at);
  return std::make_unique<SimulatedPanTilt>(servo_axes(config), at);
}

GpioBias bias_of(const std::string& name) {
  return name == "pull-up" ? GpioBias::kPullUp : name == "pull-down" ? GpioBias::kPullDown : GpioBias::kUnchanged;
}

/// "follows the landmark, a search takes 12.4 s at most": what there is to know of a head beside its hardware.
std::string habits_of(const PanTiltConfig& config, const CameraModel& camera) {
  if (!config.follow) return "stays until a command comes";
  if (!config.search) return "follows the landmark, stays where it loses it";
  const double s = std::chrono::duration<double>(Aimer(camera, aim_options(config)).sweep().longest()).count();
  return fmt::format("follows the landmark, a search takes {:.1f} s at most", s);
}

/// \param habits  of the head, for the log
std::unique_ptr<PanTilt> open_late(const Config& config, const std::string& habits,
                                   const std::shared_ptr<HeadLine>& head_line, bool follows_zoom,
                                   const DigitalInput* inhibit, std::vector<WatchedDevice>& devices) {
  const auto description = std::make_shared<DeviceNote>();
  const auto servos = [head = config.pan_tilt, head_line, follows_zoom, description, habits](const HeadAngles& at) {
    std::string text = fmt::format("{}, {}", head.driver, habits);
    std::unique_ptr<PanTilt> opened = open_servos(head, head_line, follows_zoom, at, text);
    description->set(text);
    return opened;
  };
  PoweredHeadOpener::OpenPower power;
  if (const GpioConfig& gpio = config.gpio; !gpio.servo_power.empty())
    power = [line = GpioLineOptions{gpio.servo_power, gpio.servo_power_active_low}] { return open_gpio_output(line); };
  // What answers does so under power only.
  const bool answers = config.pan_tilt.driver == "visca" || is_smart(config.pan_tilt);
  const auto opener =
      std::make_shared<PoweredHeadOpener>(servos, power, answers ? PowerComes::kFirst : PowerComes::kLast);
  LatePanTiltOptions options;
  options.start = start_angles(config.pan_tilt);
  options.reopens_failed = !is_on_a_bus(config.pan_tilt);
  if (inhibit != nullptr) options.may_move = [inhibit] { return !inhibit->is_active(); };
  auto head = std::make_unique<LatePanTilt>([opener](const HeadAngles& at) { return opener->open(at); }, options);
  devices.push_back(
      {"pan/tilt", [late = head.get()] { return late->problem(); }, [description] { return description->read(); }});
  return head;
}

std::unique_ptr<DigitalOutput> open_late_output(const char* name, const GpioLineOptions& options,
                                                std::vector<WatchedDevice>& devices) {
  // Refuses here what no waiting mends; the rest shows when it is set.
  try {
    find_gpio_line(options, list_gpio_chips());
  } catch (const DeviceAbsent&) {
  }
  auto output = std::make_unique<LateGpioOutput>([options] { return open_gpio_output(options); });
  devices.push_back({name, [late = output.get()] { return late->problem(); }, nullptr});
  return output;
}

/// udev gives a port several names; the configuration's own check knows equal ones only.
void check_ports_differ(const Config& config) {
  if ((config.pan_tilt.driver != "visca" && !is_smart(config.pan_tilt)) || !config.modbus_rtu.enabled) return;
  std::error_code absent;
  const auto head = std::filesystem::canonical(config.pan_tilt.device, absent);
  if (!absent && head == std::filesystem::canonical(config.modbus_rtu.device, absent) && !absent)
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{} and {} are one port, which serves either [pan_tilt] or "
                                                            "[modbus.rtu]; correct one of them",
                                                            config.pan_tilt.device, config.modbus_rtu.device));
}

}  // namespace

std::unique_ptr<PanTilt> open_zoom_teller(const Config& config) {
  if (!head_tells_zoom(config.pan_tilt)) return nullptr;
  check_ports_differ(config);
  std::vector<WatchedDevice> unwatched;
  return open_late(config, "is not moved", nullptr, true, nullptr, unwatched);
}

OpenedHead open_head(const Config& config, const CameraModel& camera, const std::shared_ptr<HeadLine>& head_line,
                     bool follows_zoom) {
  check_ports_differ(config);
  OpenedHead head;
  const GpioConfig& gpio = config.gpio;
  if (!gpio.status_led.empty())
    head.status_led = open_late_output("status LED", {gpio.status_led, gpio.status_led_active_low}, head.devices);
  if (!gpio.inhibit.empty()) {
    const GpioLineOptions line{gpio.inhibit, gpio.inhibit_active_low, bias_of(gpio.inhibit_bias)};
    auto inhibit = std::make_unique<InhibitInput>([line] { return open_gpio_handle(line); });
    head.devices.push_back({"inhibit input", [late = inhibit.get()] { return late->problem(); }, nullptr});
    head.inhibit = std::move(inhibit);
  }
  if (config.pan_tilt.driver != "none") {
    head.servos = open_late(config, habits_of(config.pan_tilt, camera), head_line, follows_zoom, head.inhibit.get(),
                            head.devices);
    head.output = std::make_unique<HeadOutput>(camera, aim_options(config.pan_tilt, body_geometry(config.body)),
                                               *head.servos, head.inhibit.get(), first_order(config.pan_tilt));
  } else if (!gpio.servo_power.empty()) {
    head.lone_power = open_late_output("servo power", {gpio.servo_power, gpio.servo_power_active_low}, head.devices);
  }
  return head;
}

void check_head(const Config& config,
                const std::function<void(const char* key, const std::function<void()>& step)>& attempt) {
  const auto check_line = [&](const char* key, const std::string& line) {
    attempt(key, [&] { find_gpio_line({line}, list_gpio_chips()); });
  };
  const auto check_pwm = [&](const char* key, const HeadAxisConfig& axis) {
    attempt(key, [&] { check_sysfs_pwm(kPwmRoot, axis.chip, axis.channel); });
  };
  if (config.pan_tilt.driver == "sysfs-pwm") {
    check_pwm("pan_tilt.pan.chip", config.pan_tilt.pan);
    check_pwm("pan_tilt.tilt.chip", config.pan_tilt.tilt);
  }
  if (config.pan_tilt.driver == "gpio") {
    check_line("pan_tilt.pan.line", config.pan_tilt.pan.line);
    check_line("pan_tilt.tilt.line", config.pan_tilt.tilt.line);
  }
  if (config.pan_tilt.driver == "visca") {
    attempt("pan_tilt.device", [&] { check_ports_differ(config); });
    attempt("pan_tilt.device", [&] { check_visca_port(config.pan_tilt.device); });
  }
  if (is_smart(config.pan_tilt)) {
    attempt("pan_tilt.device", [&] { check_ports_differ(config); });
    attempt("pan_tilt.device", [&] {
      const SmartServoOptions options = smart_servo_options(config.pan_tilt);
      check_servo_port(options.device, options.baud);
    });
  }
  if (config.pan_tilt.driver == "pca9685") {
    attempt("pan_tilt.device", [&] {
      open_i2c_device(config.pan_tilt.device,
                      config.pan_tilt.address < 0 ? pca9685::kFirstAddress : config.pan_tilt.address);
    });
    attempt("pan_tilt.period_ms", [&] { check_pca9685_period(pca9685_options(config.pan_tilt)); });
    if (!config.pan_tilt.output_enable.empty()) check_line("pan_tilt.output_enable", config.pan_tilt.output_enable);
  }
  const std::array<std::pair<const char*, const std::string*>, 3> lines{{{"gpio.servo_power", &config.gpio.servo_power},
                                                                         {"gpio.status_led", &config.gpio.status_led},
                                                                         {"gpio.inhibit", &config.gpio.inhibit}}};
  for (const auto& [key, line] : lines)
    if (!line->empty()) check_line(key, *line);
}

}  // namespace ninedot
