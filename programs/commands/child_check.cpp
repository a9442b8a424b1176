#include "programs/commands/child_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <exception>
#include <optional>

#include "base/one_line.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/modbus_options.h"
#include "programs/commands/child_work.h"
#include "programs/commands/config_check.h"

namespace ninedot {
namespace {

// What a line from the child is about.
constexpr char kRefused = 'R', kNote = 'N', kHost = 'H', kPort = 'P';

std::string lines_of(const ConfigToCheck& subject, CheckDepth depth) {
  ConfigProblems problems;
  Config config = read_config(subject.text, subject.name, subject.path, problems, subject.map);
  if (!subject.calibration.empty()) config.camera.calibration = subject.calibration;
  std::string lines;
  const auto add = [&](char kind, const std::string& line) { lines += kind + one_line(line) + '\n'; };
  if (depth == CheckDepth::kEverything) {
    ConfigFindings findings(problems);
    std::optional<CameraModel> camera;
    check_as_the_service(config, problems, findings, camera);
    for (const std::string& line : problem_lines(findings.problems(), subject.name)) add(kRefused, line);
    for (const std::string& line : problem_lines(findings.notes(), subject.name)) add(kNote, line);
  }
  if (config.modbus_tcp.enabled) {
    add(kHost, address_from_here(config.modbus_tcp));
    add(kPort, fmt::format("{}", config.modbus_tcp.port));
  }
  return lines;
}

CheckedConfig parsed(std::string_view lines) {
  CheckedConfig checked;
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    if (line.empty()) continue;
    const std::string_view rest = line.substr(1);
    if (line[0] == kRefused) checked.refused.emplace_back(rest);
    if (line[0] == kNote) checked.notes.emplace_back(rest);
    if (line[0] == kHost) checked.host = rest;
    if (line[0] == kPort) std::from_chars(rest.data(), rest.data() + rest.size(), checked.port);
  }
  return checked;
}

}  // namespace

CheckedConfig check_in_child(const ConfigToCheck& subject, const std::string& user, CheckDepth depth) {
  return parsed(in_child(user, "the check", [&] {
    try {
      return lines_of(subject, depth);
    } catch (const std::exception& error) {
      return kRefused + one_line(fmt::format("{}: {}", subject.name, error.what())) + '\n';
    }
  }));
}

}  // namespace ninedot
