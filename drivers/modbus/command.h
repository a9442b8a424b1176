#pragma once
/// What clients ask for by writing registers, on its way to whoever carries it out.
#include <cstdint>

#include "proto/register_map.h"

namespace ninedot {

/// At most one command and one watchdog event wait at a time: a second command takes the first one's place, a second
/// watchdog event is the same event.
struct ClientCommand {
  Command command = Command::kNone;
  std::uint16_t sequence = 0;        ///< for ModbusServer::finish_command
  double pan_rad = 0, tilt_rad = 0;  ///< the set-points when the command was given
  bool from_watchdog = false;        ///< a client fell silent; nothing to finish
};

}  // namespace ninedot
