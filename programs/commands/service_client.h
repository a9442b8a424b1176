#pragma once
/// A running service as the commands that talk to it see it: a Modbus TCP client with errors that say what to do.
#include <cstdint>
#include <span>
#include <string>

#include "drivers/modbus/client.h"
#include "proto/register_codec.h"

namespace ninedot {

/// Whether a ninedotd, of whatever version, answers there by Modbus: register 0 says so.
bool is_ninedotd_at(const std::string& host, std::uint16_t port);

/// Threads: one.
class ServiceClient {
 public:
  /// Throws StartupError(kWorkFailed): nobody answers there.
  ServiceClient(const std::string& host, std::uint16_t port);

  /// The whole map, of one frame; stays valid until the next read. Throws StartupError(kWorkFailed): no answer, or no
  /// ninedotd of this version.
  RegisterReader read();
  /// Throws StartupError(kWorkFailed): refused.
  void write(std::uint16_t first, std::span<const std::uint16_t> values);

  /// Throws StartupError(kWorkFailed) with "HOST port PORT: what".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string place_;
  ModbusTcpClient client_;
  RegisterBlock registers_{};
};

}  // namespace ninedot
