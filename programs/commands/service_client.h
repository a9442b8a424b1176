#pragma once
/// A running service as the commands that talk to it see it: a Modbus TCP client with errors that say what to do.
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/modbus/client.h"
#include "proto/register_codec.h"

namespace ninedot {

/// Why a client failed, for people: the system's word, or the client's own where the system has none. Threads: any.
std::string cause_of(const Error& error);

/// Threads: one.
class ServiceClient {
 public:
  /// Throws StartupError(kWorkFailed): nobody answers there.
  ServiceClient(const std::string& host, std::uint16_t port);

  /// The whole map, of one frame (the angles of the newest one, where frames come faster than replies); stays valid
  /// until the next read. Throws StartupError(kWorkFailed): no answer, or no ninedotd of this version.
  RegisterReader read();
  /// The same for those who wait for a lost service: connects again first where the last attempt failed.
  /// \error  kIo: no answer. Throws StartupError(kWorkFailed): no ninedotd of this version.
  Result<RegisterReader> try_read();
  /// Throws StartupError(kWorkFailed): refused.
  void write(std::uint16_t first, std::span<const std::uint16_t> values);

  /// Throws StartupError(kWorkFailed) with "HOST port PORT: what".
  [[noreturn]] void fail(const std::string& what) const;
  /// "HOST port PORT"
  std::string place() const;

 private:
  Result<void> read_all();

  const std::string host_;
  const std::uint16_t port_;
  std::optional<ModbusTcpClient> client_;  // none: lost
  RegisterBlock registers_{};
};

}  // namespace ninedot
