#include "programs/commands/service_client.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstring>

#include "base/startup_error.h"
#include "programs/display/status_view.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

ModbusTcpClient connect(const std::string& host, std::uint16_t port) {
  Result<ModbusTcpClient> client = ModbusTcpClient::connect(host, port, 2s);
  if (!client)
    throw StartupError(
        ExitStatus::kWorkFailed,
        fmt::format(
            "no service answers at {} port {} ({}): is ninedotd running, with [modbus.tcp] in its configuration?", host,
            port, std::strerror(client.error().os_errno)));
  return std::move(*client);
}

}  // namespace

bool is_ninedotd_at(const std::string& host, std::uint16_t port) {
  Result<ModbusTcpClient> client = ModbusTcpClient::connect(host, port, 2s);
  std::array<std::uint16_t, 1> magic{};
  return client && client->read_registers(reg::kMagic, magic) && magic[0] == kRegisterMapMagic;
}

ServiceClient::ServiceClient(const std::string& host, std::uint16_t port)
    : place_(fmt::format("{} port {}", host, port)), client_(connect(host, port)) {}

void ServiceClient::fail(const std::string& what) const {
  throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", place_, what));
}

RegisterReader ServiceClient::read() {
  if (const Result<void> done = client_.read_registers(0, registers_); !done)
    fail(fmt::format("{}: {}", done.error().text, std::strerror(done.error().os_errno)));
  const RegisterReader reader = make_reader(registers_);
  if (!reader.is_ninedot())
    fail(fmt::format(
        "that is no ninedotd of this version (registers 0 and 1 read {:#06x} and {}): check --host and --port",
        registers_[0], registers_[1]));
  return reader;
}

void ServiceClient::write(std::uint16_t first, std::span<const std::uint16_t> values) {
  if (const Result<void> done = client_.write_registers(first, values); !done)
    fail(fmt::format("the command was refused ({})", std::strerror(done.error().os_errno)));
}

}  // namespace ninedot
