#include "programs/commands/service_trial.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <span>

#include "base/one_line.h"
#include "drivers/posix/child_program.h"
#include "drivers/posix/file_descriptor.h"
#include "programs/commands/service_client.h"
#include "proto/register_codec.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kLook = 200ms;
constexpr auto kModbusPatience = 1s;
constexpr auto kAskPatience = 5s;  // of systemd, for a question
constexpr std::size_t kKept_bytes = 4096;
// The service counts whole seconds, from a moment before its first answer.
constexpr auto kUptimeSlack = 2s;
const std::vector<std::string> kSystemdRestart{"systemctl", "restart", "ninedotd"};
const std::vector<std::string> kSystemdState{"systemctl", "show", "--property=ActiveState,MainPID", "ninedotd"};

void keep_end(int descriptor, std::string& printed) {
  std::array<char, 4096> part{};
  for (;;) {
    const ssize_t count = ::read(descriptor, part.data(), part.size());
    if (count <= 0) return;
    printed.append(part.data(), static_cast<std::size_t>(count));
    if (printed.size() > kKept_bytes) printed.erase(0, printed.size() - kKept_bytes);
  }
}

std::string last_line_of(std::string_view text) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  const std::size_t end = text.rfind('\n');
  return one_line(std::string(end == std::string_view::npos ? text : text.substr(end + 1)));
}

std::string exit_text(int status) {
  if (WIFEXITED(status)) return fmt::format("exit status {}", WEXITSTATUS(status));
  return fmt::format("ended by signal {}", WTERMSIG(status));
}

}  // namespace

bool ServiceTrial::waits(std::chrono::nanoseconds time) {
  if (signals_.wait(time) != 0) is_interrupted_ = true;
  return !is_interrupted_;
}

ProgramOutcome ServiceTrial::run_program_for(const std::vector<std::string>& words, MonoTime until) {
  ProgramOutcome outcome;
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    outcome.what = std::strerror(errno);
    return outcome;
  }
  const FileDescriptor output(ends[0]);
  ::fcntl(output.get(), F_SETFL, O_NONBLOCK);
  FileDescriptor given(ends[1]);
  const Result<pid_t> started = start_program(words, given.get(), given.get());
  given = FileDescriptor();
  if (!started) {
    outcome.what = std::strerror(started.error().os_errno);
    return outcome;
  }
  const pid_t child = *started;
  int status = 0;
  const bool was_interrupted = is_interrupted_;  // then this is the way back, which is not broken off again
  for (;;) {
    keep_end(output.get(), outcome.printed);
    if (::waitpid(child, &status, WNOHANG) == child) break;
    const bool is_late = mono_now() >= until;
    if (!is_late && (waits(20ms) || was_interrupted)) continue;
    outcome.what = is_late ? "still running" : "interrupted";
    ::kill(-child, SIGTERM);
    ::usleep(200'000);
    ::kill(-child, SIGKILL);
    ::waitpid(child, &status, 0);
    return outcome;
  }
  keep_end(output.get(), outcome.printed);
  outcome.is_success = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  outcome.what = exit_text(status);
  outcome.last_line = last_line_of(outcome.printed);
  return outcome;
}

/// systemd's own word. A process that is another one at each look is one that does not stay.
std::optional<std::string> ServiceTrial::why_not_active() {
  const ProgramOutcome state = run_program_for(kSystemdState, mono_now() + kAskPatience);
  if (!state.is_success || state.printed.find("ActiveState=active") == std::string::npos)
    return "systemd does not call it active: `journalctl -u ninedotd` says why";
  is_new_process_ = !process_.empty() && process_ != state.printed;
  process_ = state.printed;
  return std::nullopt;
}

std::optional<std::string> ServiceTrial::why_no_answer(const std::string& host, std::uint16_t port) {
  if (!client_) {
    Result<ModbusTcpClient> client = ModbusTcpClient::connect(host, port, kModbusPatience);
    if (!client) return fmt::format("nothing answers at {} port {}: {}", host, port, cause_of(client.error()));
    client_.emplace(std::move(*client));
  }
  std::array<std::uint16_t, reg::kUptime + 2> words{};
  if (!client_->read_registers(0, words)) {
    // It is there, and lets us not in: `allow`, or every place is taken.
    client_.reset();
    return std::nullopt;
  }
  const RegisterReader reader(words);
  if (!reader.is_ninedot()) return fmt::format("at {} port {} answers something else", host, port);
  if (std::chrono::seconds(reader.integer(reg::kUptime)) > mono_now() - restarted_at_ + kUptimeSlack)
    return fmt::format("at {} port {} answers a ninedotd that is older than the restart", host, port);
  return std::nullopt;
}

std::optional<std::string> ServiceTrial::why_not_up(const std::string& host, std::uint16_t port) {
  if (options_.restart.empty())
    if (auto reason = why_not_active()) return reason;
  return host.empty() ? std::nullopt : why_no_answer(host, port);
}

std::optional<std::string> ServiceTrial::restart_and_watch(const std::string& host, std::uint16_t port) {
  const bool goes_back = is_interrupted_;
  const std::vector<std::string>& words = options_.restart.empty() ? kSystemdRestart : options_.restart;
  client_.reset();
  process_.clear();
  restarted_at_ = mono_now();
  const MonoTime until = restarted_at_ + options_.within;
  tell_("restarting", fmt::format("{}", fmt::join(words, " ")));
  const ProgramOutcome restart = run_program_for(words, until);
  if (!restart.is_success)
    return fmt::format("{}: {}{}", fmt::join(words, " "), restart.what,
                       restart.last_line.empty() ? "" : ": " + restart.last_line);
  tell_("watching", fmt::format("whether it stays up for {} s", kStays.count()));
  std::optional<MonoTime> up_since;
  std::optional<std::string> reason;
  do {
    reason = why_not_up(host, port);
    if (reason || is_new_process_) up_since.reset();
    if (reason) client_.reset();
    if (!reason && !up_since) up_since = mono_now();
    if (up_since && mono_now() - *up_since >= kStays) return std::nullopt;
    if (!waits(kLook) && !goes_back) return "interrupted";
  } while (mono_now() < until);
  return fmt::format("not up within {} s: {}", options_.within.count(), reason.value_or("it came and went"));
}

}  // namespace ninedot
