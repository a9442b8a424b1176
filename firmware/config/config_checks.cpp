#include "config/config_checks.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "base/baud_rates.h"
#include "config/head_options.h"

namespace ninedot {
namespace {

/// More than codes of eight dots can tell apart.
constexpr std::size_t kMaxLandmarks = 1000;

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

void check_geometry(const LandmarkConfig& landmark, ConfigProblems& problems) {
  // Neighbours on a regular octagon are 2 R sin(22.5 deg) apart.
  const double neighbours_mm = 2 * landmark.ring_radius_mm * std::sin(std::numbers::pi / 8);
  if (landmark.dot_diameter_mm >= neighbours_mm)
    problems.add(problems.line_of("landmark.dot_diameter_mm"),
                 fmt::format("the dots of the ring touch: dot_diameter_mm must be below {:.6g} for ring_radius_mm = {}",
                             neighbours_mm, landmark.ring_radius_mm));
  const double room_mm = 2 * landmark.ring_radius_mm - landmark.dot_diameter_mm;
  if (landmark.centre_diameter_mm >= room_mm)
    problems.add(problems.line_of("landmark.centre_diameter_mm"),
                 fmt::format("the centre dot touches the ring: centre_diameter_mm must be below {:.6g}", room_mm));
  if (landmark.centre_diameter_mm <= landmark.dot_diameter_mm)
    problems.add(problems.line_of("landmark.centre_diameter_mm"),
                 "the centre dot must be larger than the others: that is how it is recognised");
}

bool is_turn_of(const std::string& a, const std::string& b, std::size_t first_turn) {
  for (std::size_t turn = first_turn; turn < a.size(); ++turn)
    if (a.substr(turn) + a.substr(0, turn) == b) return true;
  return false;
}

void check_landmarks(const std::vector<MapLandmarkConfig>& landmarks, ConfigProblems& problems) {
  const auto line_of = [&](std::size_t i, const char* key) {
    return problems.line_of(fmt::format("landmarks.{}.{}", i, key));
  };
  const std::string black_and_white = "KKKKKKKK";
  if (landmarks.size() > kMaxLandmarks)
    return problems.add(line_of(kMaxLandmarks, "id"), fmt::format("more than {} landmarks", kMaxLandmarks));
  std::vector<std::string> codes;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    std::string code = landmarks[i].code.empty() ? black_and_white : landmarks[i].code;
    if (code.size() != 8 || code.find_first_not_of("KRGB") != std::string::npos) {
      problems.add(line_of(i, "code"),
                   fmt::format("'code' is '{}'; write eight of K R G B for P1..P8", landmarks[i].code));
      code.clear();
    } else if (code != black_and_white && is_turn_of(code, code, 1)) {
      problems.add(line_of(i, "code"),
                   fmt::format("'code' {} looks the same when the sheet is turned; choose another", code));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (landmarks[j].id == landmarks[i].id)
        problems.add(line_of(i, "id"), fmt::format("two landmarks have the id {}", landmarks[i].id));
      if (!code.empty() && is_turn_of(code, codes[j], 0))
        problems.add(line_of(i, "code"),
                     fmt::format("landmarks {} and {} can't be told apart: their codes are turns of each other",
                                 landmarks[j].id, landmarks[i].id));
    }
    codes.push_back(code);
  }
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

void check_head(const PanTiltConfig& pan_tilt, ConfigProblems& problems) {
  if (pan_tilt.driver == "none") return;
  if (const HeadProblem problem = find_head_problem(pan_tilt); !problem.what.empty())
    problems.add(problems.line_of(problem.key), problem.what);
}

}  // namespace

int ConfigProblems::line_of(std::string_view key) const {
  for (;;) {
    if (const auto found = lines.find(key); found != lines.end()) return found->second;
    const std::size_t dot = key.rfind('.');
    if (dot == std::string_view::npos) return 1;
    key = key.substr(0, dot);
  }
}

void check_config(const Config& config, ConfigProblems& problems) {
  check_geometry(config.landmark, problems);
  check_landmarks(config.landmarks, problems);
  check_head(config.pan_tilt, problems);
  check_modbus(config, problems);
}

}  // namespace ninedot
