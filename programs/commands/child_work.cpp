#include "programs/commands/child_work.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <exception>
#include <span>

#include "base/startup_error.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {
namespace {

constexpr std::size_t kMaxText_bytes = std::size_t{1} << 20U;
constexpr unsigned kPatience_s = 60;
// The first byte from the child, and its last.
constexpr char kReturned = 'R', kWrong = 'W', kFailed = 'F', kWhole = '.';

void take_rights_of(const passwd& user) {
  if (::initgroups(user.pw_name, user.pw_gid) != 0 || ::setgid(user.pw_gid) != 0 || ::setuid(user.pw_uid) != 0)
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", user.pw_name, std::strerror(errno)));
}

std::string outcome_of(const passwd* user, const std::function<std::string()>& work) {
  try {
    if (user != nullptr) take_rights_of(*user);
    return kReturned + work();
  } catch (const StartupError& error) {
    return (error.status == ExitStatus::kWrongUsage ? kWrong : kFailed) + std::string(error.what());
  } catch (const std::exception& error) {
    return kFailed + std::string(error.what());
  }
}

/// In the child. Does not come back.
[[noreturn]] void run_child(int answer, const passwd* user, const std::function<std::string()>& work) {
  ::alarm(kPatience_s);
  const std::string text = outcome_of(user, work) + kWhole;
  const auto bytes = std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  ::_exit(write_all(answer, bytes, write_to_disk) ? 0 : 1);
}

std::string all_of(int descriptor) {
  std::string text;
  std::array<char, 4096> part{};
  while (text.size() < kMaxText_bytes) {
    const ssize_t count = ::read(descriptor, part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    text.append(part.data(), static_cast<std::size_t>(count));
  }
  return text;
}

}  // namespace

std::string in_child(const std::string& user, const std::string& name, const std::function<std::string()>& work) {
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
  if (child == 0) run_child(told.get(), entry, work);
  told = FileDescriptor();
  std::string text = all_of(answer.get());
  // One that still talks, or hangs, has been heard enough.
  ::kill(child, SIGKILL);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (text.size() < 2 || text.back() != kWhole)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("{} did not come to its end within {} s, so nothing is changed: `ninedot check` may "
                                   "say why",
                                   name, kPatience_s));
  const char outcome = text.front();
  text = text.substr(1, text.size() - 2);
  if (outcome == kReturned) return text;
  throw StartupError(outcome == kWrong ? ExitStatus::kWrongUsage : ExitStatus::kWorkFailed, text);
}

}  // namespace ninedot
