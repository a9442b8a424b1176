#pragma once
/// Reads registers of a running service: for `ninedot status` and the tests.
#include <modbus/modbus.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"

namespace ninedot {

/// One connection. Move-only. Threads: one.
class ModbusTcpClient {
 public:
  /// \param timeout  of the connection and of each reply
  /// \error kIo: nobody answers there, os_errno says why; 0: no address is known for the name. Waits for the name's
  /// look-up, for which the system has a time of its own.
  static Result<ModbusTcpClient> connect(const std::string& host, std::uint16_t port,
                                         std::chrono::milliseconds timeout);

  /// Fills `registers`, at most 125, from consecutive addresses (function code 03): one request, one frame.
  /// \error kIo: refused (an exception), no answer in time, or the connection is over. Connect again.
  Result<void> read_registers(std::uint16_t first, std::span<std::uint16_t> registers) noexcept;

  /// Function code 16. \error as read_registers; os_errno is EBUSY where another client came first (register
  /// `give_way`)
  Result<void> write_registers(std::uint16_t first, std::span<const std::uint16_t> values) noexcept;

 private:
  struct Close {
    void operator()(modbus_t* connection) const noexcept;
  };
  explicit ModbusTcpClient(modbus_t* connection) noexcept : connection_(connection) {}
  std::unique_ptr<modbus_t, Close> connection_;
};

}  // namespace ninedot
