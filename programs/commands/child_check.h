#pragma once
/// A configuration's check in a process of its own (child_work.h): what the text says of files and devices is looked at
/// with that process's rights.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ninedot {

struct CheckedConfig {
  std::vector<std::string> refused;  ///< "NAME:LINE: what", as `ninedot check` says it
  std::vector<std::string> notes;    ///< "NAME:LINE: note: what"
  std::string host;                  ///< where Modbus TCP is asked from this machine; empty: it is not served
  std::uint16_t port = 0;
};

enum class CheckDepth : std::uint8_t {
  kEverything,    ///< as `ninedot check`
  kEndpointOnly,  ///< host and port
};

struct ConfigToCheck {
  std::string_view text;    ///< at most kMaxApplied_bytes; lifetime: until it is checked
  std::string name;         ///< how its lines call it
  std::string path;         ///< the file that it is to become
  std::string calibration;  ///< a file that is looked at in the place of the camera's; empty: the one that it names
  std::string map = {};     ///< likewise of the map's
};

/// \param user  whose rights it has; empty: the caller's
/// Throws StartupError as in_child does, but for a text that is refused. Memory, threads: as in_child.
CheckedConfig check_in_child(const ConfigToCheck& subject, const std::string& user, CheckDepth depth);

}  // namespace ninedot
