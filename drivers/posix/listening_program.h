#pragma once
/// Who listens on a TCP port of this machine, as far as the kernel tells this user.
#include <cstdint>
#include <string>
#include <string_view>

namespace ninedot {

enum class Listening {
  kNo,     ///< no process of that name does
  kMaybe,  ///< one of that name runs whose sockets this user may not see
  kYes,
};

/// Whether a process called `program` listens on a TCP port, on whichever address.
/// \param program  as in /proc/PID/comm, at most 15 characters
/// \param proc  the kernel's /proc, or a test's own
/// Memory: allocates. Threads: pure; may wait for the kernel's files.
Listening find_listener(std::string_view program, std::uint16_t port, const std::string& proc = "/proc");

}  // namespace ninedot
