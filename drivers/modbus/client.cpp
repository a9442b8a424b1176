#include "drivers/modbus/client.h"

#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>

#include "base/contract.h"

namespace ninedot {
namespace {

/// libmodbus's own numbers lie far above those of the operating system.
tl::unexpected<Error> failure(int error) noexcept {
  if (error == EMBXSBUSY) return fail(Errc::kIo, "another client has written there first", EBUSY);
  if (error > MODBUS_ENOBASE && error <= EMBXGTAR)
    return fail(Errc::kIo, "the server refused the request with a Modbus exception");
  if (error > MODBUS_ENOBASE) return fail(Errc::kIo, "the server's answer is no valid Modbus reply");
  return fail(Errc::kIo, error == ETIMEDOUT ? "the Modbus server did not answer in time" : "no Modbus connection",
              error);
}

/// libmodbus looks the name up itself, and calls one that it does not find a refused connection.
bool leads_to_an_address(const std::string& host, const std::string& port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return false;
  ::freeaddrinfo(found);
  return true;
}

}  // namespace

void ModbusTcpClient::Close::operator()(modbus_t* connection) const noexcept {
  modbus_close(connection);
  modbus_free(connection);
}

Result<ModbusTcpClient> ModbusTcpClient::connect(const std::string& host, std::uint16_t port,
                                                 std::chrono::milliseconds timeout) {
  const std::string service = std::to_string(port);
  if (!leads_to_an_address(host, service)) return fail(Errc::kIo, "no address is known for this name");
  ModbusTcpClient client(modbus_new_tcp_pi(host.c_str(), service.c_str()));
  modbus_t* const connection = client.connection_.get();
  if (connection == nullptr) return fail(Errc::kIo, "no Modbus connection", errno);
  const auto seconds = static_cast<std::uint32_t>(timeout.count() / 1000);
  const auto microseconds = static_cast<std::uint32_t>(timeout.count() % 1000 * 1000);
  (void)modbus_set_response_timeout(connection, seconds, microseconds);
  if (modbus_connect(connection) != 0) return failure(errno);
  return client;
}

Result<void> ModbusTcpClient::read_registers(std::uint16_t first, std::span<std::uint16_t> registers) noexcept {
  EXPECTS(!registers.empty() && registers.size() <= MODBUS_MAX_READ_REGISTERS);
  if (modbus_read_registers(connection_.get(), first, static_cast<int>(registers.size()), registers.data()) < 0)
    return failure(errno);
  return {};
}

Result<void> ModbusTcpClient::write_registers(std::uint16_t first, std::span<const std::uint16_t> values) noexcept {
  EXPECTS(!values.empty() && values.size() <= MODBUS_MAX_WRITE_REGISTERS);
  if (modbus_write_registers(connection_.get(), first, static_cast<int>(values.size()), values.data()) < 0)
    return failure(errno);
  return {};
}

}  // namespace ninedot
