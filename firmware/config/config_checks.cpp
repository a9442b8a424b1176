#include "config/config_checks.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <iterator>
#include <map>
#include <utility>

#include "base/baud_rates.h"
#include "config/head_options.h"
#include "config/landmark_checks.h"
#include "config/simulation_keys.h"
#include "geometry/landmark_faults.h"

namespace ninedot {
namespace {

bool is_address(const std::string& text) {
  in6_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1 || ::inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

/// "10.0.0.1", "10.0.0.0/8", "fe80::/10"
bool is_network(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (!is_address(text.substr(0, slash))) return false;
  if (slash == std::string::npos) return true;
  const int max_length = text.find(':') == std::string::npos ? 32 : 128;
  int length = -1;
  const auto [end, error] = std::from_chars(text.data() + slash + 1, text.data() + text.size(), length);
  return error == std::errc{} && end == text.data() + text.size() && length >= 0 && length <= max_length;
}

/// As it can stand in an address: letters, digits, '.', '-' and '_', or an IP address.
bool is_host_name(const std::string& text) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
           c == '_';
  };
  return is_address(text) || (!text.empty() && std::all_of(text.begin(), text.end(), is_letter));
}

void check_geometry(const LandmarkConfig& landmark, ConfigProblems& problems) {
  const LandmarkFaults faults = find_landmark_faults(
      {landmark.ring_radius_mm, landmark.dot_diameter_mm / 2, landmark.centre_diameter_mm / 2});  // in mm here
  if (faults.ring_dots_touch)
    problems.add(problems.line_of("landmark.dot_diameter_mm"),
                 fmt::format("the dots of the ring touch: dot_diameter_mm must be below {:.6g} for ring_radius_mm = {}",
                             faults.dot_diameter_below, landmark.ring_radius_mm));
  if (faults.centre_touches_ring)
    problems.add(problems.line_of("landmark.centre_diameter_mm"),
                 fmt::format("the centre dot touches the ring: centre_diameter_mm must be below {:.6g}",
                             faults.centre_diameter_below));
  if (faults.centre_not_largest)
    problems.add(problems.line_of("landmark.centre_diameter_mm"),
                 "the centre dot must be larger than the others: that is how it is recognised");
}

void check_camera(const CameraConfig& camera, ConfigProblems& problems) {
  if (camera.every_frame && camera.source != "recording")
    problems.add(problems.line_of("camera.every_frame"),
                 fmt::format("'every_frame' is of recordings, and source is {}: take it out", camera.source));
  // What belongs to a sensor's own numbers says nothing of pictures that the camera has made of them.
  const std::string& format = camera.pixel_format;
  if (format == "auto" || format.find("GG") != std::string::npos || format.find("RBG") != std::string::npos ||
      format.find("BRG") != std::string::npos)
    return;
  const CameraConfig usual;
  const auto check = [&](const char* name, double value, double usual_value) {
    if (value != usual_value)
      problems.add(problems.line_of(fmt::format("camera.{}", name)),
                   fmt::format("'{}' is of Bayer formats, and pixel_format is {}: take it out", name, format));
  };
  check("black_level", camera.black_level, usual.black_level);
  check("red_gain", camera.red_gain, usual.red_gain);
  check("blue_gain", camera.blue_gain, usual.blue_gain);
}

void check_modbus(const Config& config, ConfigProblems& problems) {
  if (!is_address(config.modbus_tcp.listen))
    problems.add(problems.line_of("modbus.tcp.listen"),
                 fmt::format("'listen' is '{}'; write an IPv4 or IPv6 address", config.modbus_tcp.listen));
  for (const std::string& peer : config.modbus_tcp.allow)
    if (!is_network(peer))
      problems.add(problems.line_of("modbus.tcp.allow"),
                   fmt::format("'allow' lists '{}'; write addresses like 10.0.0.1 or 10.0.0.0/8", peer));
  if (!is_baud_rate(config.modbus_rtu.baud))
    problems.add(problems.line_of("modbus.rtu.baud"),
                 fmt::format("'baud' is {}; write one of {}", config.modbus_rtu.baud, fmt::join(kBaudRates, ", ")));
  if (config.modbus_rtu.device.empty()) problems.add(problems.line_of("modbus.rtu.device"), "'device' is empty");
}

/// Addresses, channels and servos' numbers, whose ranges depend on the driver.
void check_addresses(const PanTiltConfig& head, ConfigProblems& problems) {
  const auto check = [&](const char* key, int value, int first, int last, const char* written) {
    if (value < first || value > last)
      problems.add(problems.line_of(key),
                   fmt::format("'{}' is {}; write {}",
                               std::string_view(key).substr(std::string_view(key).rfind('.') + 1), value, written));
  };
  if (head.driver == "visca" && head.address != -1) check("pan_tilt.address", head.address, 1, 7, "1 to 7");
  if (head.driver != "pca9685") return;
  if (head.address != -1) check("pan_tilt.address", head.address, 0x40, 0x77, "0x40 to 0x77");
  check("pan_tilt.pan.channel", head.pan.channel, 0, 15, "0 to 15");
  check("pan_tilt.tilt.channel", head.tilt.channel, 0, 15, "0 to 15");
}

void check_web(const Config& config, ConfigProblems& problems) {
  const WebConfig& web = config.web;
  if (!is_address(web.listen))
    problems.add(problems.line_of("web.listen"),
                 fmt::format("'listen' is '{}'; write an IPv4 or IPv6 address", web.listen));
  else if (!is_loopback(web.listen) && web.token_file.empty())
    problems.add(
        problems.line_of("web.listen"),
        fmt::format("'listen' is '{}', which other machines can reach: write a 'token_file' as well", web.listen));
  for (const std::string& name : web.names)
    if (!is_host_name(name))
      problems.add(problems.line_of("web.names"),
                   fmt::format("'names' lists '{}'; write names like sensor.local, without http:// and port", name));
  if (web.certificate.empty() != web.key.empty())
    problems.add(problems.line_of(web.key.empty() ? "web.certificate" : "web.key"),
                 "TLS needs both 'certificate' and 'key'");
  if (!web.recordings.empty() && !web.recordings.starts_with('/'))
    problems.add(problems.line_of("web.recordings"),
                 fmt::format("'recordings' is '{}'; write a folder that begins with /", web.recordings));
  if (web.loss_seconds > 0 && web.recordings.empty())
    problems.add(problems.line_of("web.loss_seconds"), "'loss_seconds' needs a folder: write 'recordings' as well");
  if (config.tap.enabled && config.tap.path.empty())
    problems.add(problems.line_of("tap.path"), "'path' is empty; write a file's name");
}

void check_head(const PanTiltConfig& head, ConfigProblems& problems) {
  if (head.driver == "none") return;
  check_head_axes(head, problems);
  const auto need = [&](std::string_view key, const std::string& name, std::string_view what) {
    if (name.empty())
      problems.add(problems.line_of(key), fmt::format("'{}' is empty; write {}", key.substr(key.rfind('.') + 1), what));
  };
  const bool is_smart = head.driver == "dynamixel" || head.driver.starts_with("feetech");
  if (head.driver == "visca") need("pan_tilt.device", head.device, "the camera's serial port");
  if (is_smart) need("pan_tilt.device", head.device, "the servos' serial port");
  if (head.driver == "pca9685") need("pan_tilt.device", head.device, "the I2C bus, like /dev/i2c-1");
  check_addresses(head, problems);
  if (is_smart && head.baud != 0 && !is_servo_baud_rate(head.baud))
    problems.add(problems.line_of("pan_tilt.baud"),
                 fmt::format("'baud' is {}; write one of {}, or 0", head.baud, fmt::join(kServoBaudRates, ", ")));
  for (const auto& [table, axis] : {std::pair("pan_tilt.pan", &head.pan), std::pair("pan_tilt.tilt", &head.tilt)}) {
    if (head.driver == "sysfs-pwm")
      need(fmt::format("{}.chip", table), axis->chip, "the device of the PWM chip, like fe20c000.pwm");
    if (head.driver == "gpio") need(fmt::format("{}.line", table), axis->line, "a GPIO line's name, or LABEL:OFFSET");
  }
}

/// Whoever comes first has a device; the other one would wait for ever.
void check_sharing(const Config& config, ConfigProblems& problems) {
  struct Use {
    const char* key;
    std::string device;  ///< empty: none
  };
  std::vector<Use> uses{{"gpio.servo_power", config.gpio.servo_power},
                        {"gpio.inhibit", config.gpio.inhibit},
                        {"gpio.status_led", config.gpio.status_led}};
  const PanTiltConfig& head = config.pan_tilt;
  const auto port = [](const std::string& path) { return std::filesystem::path(path).lexically_normal().string(); };
  const auto pwm = [](const HeadAxisConfig& axis) {
    return axis.chip.empty() ? "" : fmt::format("{} of {}", axis.channel, axis.chip);
  };
  if (head.driver == "gpio") {
    uses.push_back({"pan_tilt.pan.line", head.pan.line});
    uses.push_back({"pan_tilt.tilt.line", head.tilt.line});
  }
  if (head.driver == "sysfs-pwm") {
    uses.push_back({"pan_tilt.pan.channel", pwm(head.pan)});
    uses.push_back({"pan_tilt.tilt.channel", pwm(head.tilt)});
  }
  const bool is_smart = head.driver == "dynamixel" || head.driver.starts_with("feetech");
  if (head.driver == "visca" || is_smart) uses.push_back({"pan_tilt.device", port(head.device)});
  if (head.driver == "pca9685") {
    uses.push_back({"pan_tilt.output_enable", head.output_enable});
    uses.push_back({"pan_tilt.pan.channel", fmt::format("channel {}", head.pan.channel)});
    uses.push_back({"pan_tilt.tilt.channel", fmt::format("channel {}", head.tilt.channel)});
  }
  if (is_smart) {
    uses.push_back({"pan_tilt.pan.id", fmt::format("servo {}", head.pan.id)});
    uses.push_back({"pan_tilt.tilt.id", fmt::format("servo {}", head.tilt.id)});
  }
  if (config.modbus_rtu.enabled) uses.push_back({"modbus.rtu.device", port(config.modbus_rtu.device)});
  for (std::size_t i = 0; i < uses.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!uses[i].device.empty() && uses[i].device == uses[j].device)
        problems.add(problems.line_of(uses[i].key), fmt::format("{} and {} are both '{}'; a device serves one of them",
                                                                uses[i].key, uses[j].key, uses[i].device));
}

}  // namespace

bool is_loopback(const std::string& address) { return address == "::1" || address.starts_with("127."); }

int ConfigProblems::line_of(std::string_view key) const {
  for (;;) {
    if (const auto found = lines.find(key); found != lines.end()) return found->second;
    const std::size_t dot = key.rfind('.');
    if (dot == std::string_view::npos) return 1;
    key = key.substr(0, dot);
  }
}

bool ConfigProblems::is_in(std::string_view table) const {
  // The table of a line is that of the nearest key above. By line, so that a file of nothing but mistakes, thousands of
  // them, costs no more than reading it.
  std::map<int, std::string_view> keys;
  for (const auto& [key, at] : lines) keys[at] = key;
  const auto table_at = [&](int line) {
    const auto below = keys.upper_bound(line);
    const std::string_view nearest = below == keys.begin() ? std::string_view() : std::prev(below)->second;
    return nearest.substr(0, nearest.find('.'));
  };
  return std::ranges::any_of(list, [&](const ConfigProblem& problem) {
    return (problem.file.empty() ? table_at(problem.line) : "landmarks") == table;
  });
}

void check_config(const Config& config, ConfigProblems& problems) {
  check_geometry(config.landmark, problems);
  check_landmarks(config, problems);
  if (config.map.empty()) check_outputs(config, problems);
  check_head(config.pan_tilt, problems);
  check_camera(config.camera, problems);
  check_modbus(config, problems);
  check_web(config, problems);
  check_sharing(config, problems);
  check_simulation(config, problems);
}

}  // namespace ninedot
