#pragma once
/// What the servers tell about themselves: for `status`, the log, and the registers.
#include <chrono>
#include <cstdint>
#include <string>

namespace ninedot {

/// One client, for a display. The serial line is one client.
struct ConnectedClient {
  std::string address;  ///< "192.168.1.7:40012", "[::1]:40012", "/dev/ttyS1 unit 1"
  std::uint64_t requests = 0;
  std::chrono::nanoseconds connected_for{};
  std::chrono::nanoseconds silent_for{};  ///< since its last complete request, or since it connected
};

struct ModbusCounters {
  std::uint64_t requests = 0;
  std::uint64_t exceptions = 0;           ///< requests answered with an exception
  std::uint64_t bus_errors = 0;           ///< broken frames and check sums on both, losses of the serial line
  std::uint64_t unreadable_frames = 0;    ///< of them the broken frames and check sums
  std::uint64_t connections = 0;          ///< accepted
  std::uint64_t refused_connections = 0;  ///< not on the list, or no place
  std::uint64_t expired_connections = 0;  ///< closed by us: idle, not reading its replies, displaced
  std::uint64_t foreign_frames = 0;       ///< of other units on the serial line
  std::uint64_t serial_losses = 0;        ///< the serial device vanished
  bool serial_open = false;
};

}  // namespace ninedot
