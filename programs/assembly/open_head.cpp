#include "programs/assembly/open_head.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "base/contract.h"
#include "base/startup_error.h"
#include "config/head_options.h"
#include "drivers/gpio/gpio_lines.h"
#include "drivers/servo/gpio_pan_tilt.h"
#include "drivers/servo/late_pan_tilt.h"
#include "drivers/servo/powered_head.h"
#include "drivers/servo/simulated_pan_tilt.h"
#include "drivers/servo/sysfs_pwm.h"
#include "drivers/servo/visca_pan_tilt.h"

namespace ninedot {
namespace {

constexpr const char* kPwmRoot = "/sys/class/pwm";

std::chrono::nanoseconds period_of(const PanTiltConfig& config) {
  return std::chrono::nanoseconds(std::llround(config.period_ms * 1e6));
}

std::unique_ptr<PanTilt> open_sysfs_pwm(const PanTiltConfig& config) {
  SysfsPanTiltOptions options;
  options.root = kPwmRoot;
  options.pan_chip = config.pan.chip;
  options.pan_channel = config.pan.channel;
  options.tilt_chip = config.tilt.chip;
  options.tilt_channel = config.tilt.channel;
  options.period = period_of(config);
  return std::make_unique<SysfsPanTilt>(options, servo_axes(config), aim_options(config).neutral);
}

std::unique_ptr<PanTilt> open_gpio(const PanTiltConfig& config, std::string& description) {
  auto pan = open_gpio_output({config.pan.line}), tilt = open_gpio_output({config.tilt.line});
  const GpioPanTiltOptions options{period_of(config), config.pulse_priority};
  auto head = std::make_unique<GpioPanTilt>(std::move(pan), std::move(tilt), options, servo_axes(config),
                                            aim_options(config).neutral);
  if (const Result<void>& realtime = head->realtime(); !realtime)
    description += fmt::format(", pulses without real-time priority ({}): allow it with LimitRTPRIO= or `ulimit -r`",
                               std::strerror(realtime.error().os_errno));
  return head;
}

std::unique_ptr<PanTilt> open_visca(const PanTiltConfig& config, std::string& description) {
  ViscaOptions options;
  options.device = config.device;
  options.address = config.address;
  if (config.zoom >= 0) options.zoom = config.zoom;
  auto head = std::make_unique<ViscaPanTilt>(options, servo_axes(config), aim_options(config).neutral);
  if (const auto focal_length_mm = head->focal_length_mm())
    description += fmt::format(", zoom {} (f = {:.1f} mm)", head->zoom().value_or(config.zoom), *focal_length_mm);
  return head;
}

std::unique_ptr<PanTilt> open_servos(const PanTiltConfig& config, std::string& description) {
  if (config.driver == "sysfs-pwm") return open_sysfs_pwm(config);
  if (config.driver == "gpio") return open_gpio(config, description);
  if (config.driver == "visca") return open_visca(config, description);
  EXPECTS(config.driver == "simulated");
  return std::make_unique<SimulatedPanTilt>(servo_axes(config), aim_options(config).neutral);
}

GpioBias bias_of(const std::string& name) {
  return name == "pull-up" ? GpioBias::kPullUp : name == "pull-down" ? GpioBias::kPullDown : GpioBias::kUnchanged;
}

std::unique_ptr<PanTilt> open_late(const Config& config, const DigitalInput* inhibit,
                                   std::vector<WatchedDevice>& devices) {
  const auto description = std::make_shared<DeviceNote>();
  const auto servos = [head = config.pan_tilt, description] {
    std::string text =
        fmt::format("{}, {}", head.driver, head.follow ? "follows the landmark" : "stays until a command comes");
    std::unique_ptr<PanTilt> opened = open_servos(head, text);
    description->set(text);
    return opened;
  };
  PoweredHeadOpener::OpenPower power;
  if (const GpioConfig& gpio = config.gpio; !gpio.servo_power.empty())
    power = [line = GpioLineOptions{gpio.servo_power, gpio.servo_power_active_low}] { return open_gpio_output(line); };
  const bool is_camera = config.pan_tilt.driver == "visca";
  const auto opener =
      std::make_shared<PoweredHeadOpener>(servos, power, is_camera ? PowerComes::kFirst : PowerComes::kLast);
  LatePanTiltOptions options;
  options.neutral = aim_options(config.pan_tilt).neutral;
  options.reopens_failed = !is_camera;
  if (inhibit != nullptr) options.may_move = [inhibit] { return !inhibit->is_active(); };
  auto head = std::make_unique<LatePanTilt>([opener] { return opener->open(); }, options);
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
  if (config.pan_tilt.driver != "visca" || !config.modbus_rtu.enabled) return;
  std::error_code absent;
  const auto head = std::filesystem::canonical(config.pan_tilt.device, absent);
  if (!absent && head == std::filesystem::canonical(config.modbus_rtu.device, absent) && !absent)
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{} and {} are one port, which serves either [pan_tilt] or "
                                                            "[modbus.rtu]; correct one of them",
                                                            config.pan_tilt.device, config.modbus_rtu.device));
}

}  // namespace

OpenedHead open_head(const Config& config, const CameraModel& camera) {
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
    head.servos = open_late(config, head.inhibit.get(), head.devices);
    head.output = std::make_unique<HeadOutput>(camera, aim_options(config.pan_tilt), *head.servos, head.inhibit.get(),
                                               first_order(config.pan_tilt));
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
  const std::array<std::pair<const char*, const std::string*>, 3> lines{{{"gpio.servo_power", &config.gpio.servo_power},
                                                                         {"gpio.status_led", &config.gpio.status_led},
                                                                         {"gpio.inhibit", &config.gpio.inhibit}}};
  for (const auto& [key, line] : lines)
    if (!line->empty()) check_line(key, *line);
}

}  // namespace ninedot
