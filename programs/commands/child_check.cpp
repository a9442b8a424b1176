#include "programs/commands/child_check.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <exception>
#include <optional>
#include <span>

#include "base/one_line.h"
#include "base/startup_error.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/whole_file.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/config_check.h"

namespace ninedot {
namespace {

constexpr std::size_t kMaxLines_bytes = std::size_t{1} << 20U;
constexpr unsigned kPatience_s = 60;
// What a line from the child is about.
constexpr char kRefused = 'R', kNote = 'N', kHost = 'H', kPort = 'P', kWhole = '.';

std::string host_from_here(const std::string& listen) {
  return listen == "0.0.0.0" ? "127.0.0.1" : listen == "::" ? "::1" : listen;
}

void take_rights_of(const passwd& user) {
  if (::initgroups(user.pw_name, user.pw_gid) != 0 || ::setgid(user.pw_gid) != 0 || ::setuid(user.pw_uid) != 0)
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", user.pw_name, std::strerror(errno)));
}

std::string lines_of(const ConfigToCheck& subject, CheckDepth depth) {
  ConfigProblems problems;
  Config config = read_config(subject.text, subject.name, subject.path, problems);
  if (!subject.calibration.empty()) config.camera.calibration = subject.calibration;
  std::string lines;
  const auto add = [&](char kind, const std::string& line) { lines += kind + one_line(line) + '\n'; };
  if (depth == CheckDepth::kEverything) {
    ConfigFindings findings(problems);
    std::optional<CameraModel> camera;
    check_as_the_service(config, problems, findings, camera);
    for (const std::string& line : problem_lines(findings, subject.name)) add(kRefused, line);
    for (const std::string& line : note_lines(findings, subject.name)) add(kNote, line);
  }
  if (config.modbus_tcp.enabled) {
    add(kHost, host_from_here(config.modbus_tcp.listen));
    add(kPort, fmt::format("{}", config.modbus_tcp.port));
  }
  add(kWhole, "");
  return lines;
}

/// In the child; says why where it can't. Does not come back.
[[noreturn]] void run_child(int answer, const passwd* user, const ConfigToCheck& subject, CheckDepth depth) {
  ::alarm(kPatience_s);
  std::string lines;
  try {
    if (user != nullptr) take_rights_of(*user);
    lines = lines_of(subject, depth);
  } catch (const std::exception& error) {
    lines = kRefused + one_line(fmt::format("{}: {}", subject.name, error.what())) + "\n.\n";
  }
  const auto bytes = std::span(reinterpret_cast<const std::uint8_t*>(lines.data()), lines.size());
  ::_exit(write_all(answer, bytes, write_to_disk) ? 0 : 1);
}

std::string all_of(int descriptor) {
  std::string lines;
  std::array<char, 4096> part{};
  while (lines.size() < kMaxLines_bytes) {
    const ssize_t count = ::read(descriptor, part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    lines.append(part.data(), static_cast<std::size_t>(count));
  }
  return lines;
}

CheckedConfig parsed(std::string_view lines) {
  CheckedConfig checked;
  bool is_whole = false;
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    if (line.empty()) continue;
    const std::string_view rest = line.substr(1);
    if (line[0] == kRefused) checked.refused.emplace_back(rest);
    if (line[0] == kNote) checked.notes.emplace_back(rest);
    if (line[0] == kHost) checked.host = rest;
    if (line[0] == kPort) std::from_chars(rest.data(), rest.data() + rest.size(), checked.port);
    is_whole = line[0] == kWhole;
  }
  if (!is_whole)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("the check did not come to its end within {} s, so nothing is changed: `ninedot "
                                   "check` may say why",
                                   kPatience_s));
  return checked;
}

}  // namespace

CheckedConfig check_in_child(const ConfigToCheck& subject, const std::string& user, CheckDepth depth) {
  const passwd* const entry = user.empty() ? nullptr : ::getpwnam(user.c_str());
  if (!user.empty() && entry == nullptr)
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}: there is no such user to check as", user));
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("no pipe can be made: {}", std::strerror(errno)));
  const FileDescriptor answer(ends[0]);
  FileDescriptor told(ends[1]);
  const pid_t child = ::fork();
  if (child < 0)
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("no process can be made: {}", std::strerror(errno)));
  if (child == 0) run_child(told.get(), entry, subject, depth);
  told = FileDescriptor();
  const std::string lines = all_of(answer.get());
  // One that still talks, or hangs, has been heard enough.
  ::kill(child, SIGKILL);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  return parsed(lines);
}

}  // namespace ninedot
