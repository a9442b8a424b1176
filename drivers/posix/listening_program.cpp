// The kernel lists its sockets with their inodes (/proc/net/tcp), and shows each descriptor of a process as a link,
// "socket:[INODE]" (/proc/PID/fd), to the process's own user and to root. See proc(5).
#include "drivers/posix/listening_program.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <system_error>

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// As links of descriptors: "socket:[4711]".
std::set<std::string> listening_sockets(std::uint16_t port, const std::string& proc) {
  constexpr const char* kListening = "0A";  // TCP_LISTEN of the kernel's tcp_states.h
  const std::string at_port = fmt::format(":{:04X}", port);
  std::set<std::string> sockets;
  for (const char* table : {"tcp", "tcp6"}) {
    std::ifstream file(fmt::format("{}/net/{}", proc, table));
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string slot, local, remote, state, queues, timer, retransmits, user, timeout, inode;
      words >> slot >> local >> remote >> state >> queues >> timer >> retransmits >> user >> timeout >> inode;
      if (state == kListening && local.ends_with(at_port)) sockets.insert(fmt::format("socket:[{}]", inode));
    }
  }
  return sockets;
}

bool is_called(const fs::path& process, std::string_view program) {
  std::ifstream file(process / "comm");
  std::string name;
  return std::getline(file, name) && name == program;
}

Listening holds_any(const fs::path& process, const std::set<std::string>& sockets) {
  std::error_code error;
  for (fs::directory_iterator at(process / "fd", error); at != fs::directory_iterator(); at.increment(error)) {
    std::error_code closed_meanwhile;
    if (sockets.contains(fs::read_symlink(at->path(), closed_meanwhile).string())) return Listening::kYes;
  }
  const bool has_ended = error == std::errc::no_such_file_or_directory;
  return error && !has_ended ? Listening::kMaybe : Listening::kNo;
}

}  // namespace

Listening find_listener(std::string_view program, std::uint16_t port, const std::string& proc) {
  const std::set<std::string> sockets = listening_sockets(port, proc);
  if (sockets.empty()) return Listening::kNo;
  Listening found = Listening::kNo;
  std::error_code error;
  for (fs::directory_iterator at(proc, error); at != fs::directory_iterator(); at.increment(error)) {
    if (!is_called(at->path(), program)) continue;
    const Listening answer = holds_any(at->path(), sockets);
    if (answer == Listening::kYes) return answer;
    if (answer == Listening::kMaybe) found = answer;
  }
  return found;
}

}  // namespace ninedot
