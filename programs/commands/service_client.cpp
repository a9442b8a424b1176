#include "programs/commands/service_client.h"

#include <fmt/format.h>

#include <chrono>
#include <cstring>

#include "base/startup_error.h"
#include "programs/display/status_view.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 2s;
constexpr std::uint16_t kFirstRead = 125;  // what one request reads
constexpr int kAttempts = 4;               // to read both parts of one frame

/// What the system says of it, where it knows anything.
std::string with_cause(const Error& error) {
  return error.os_errno == 0 ? error.text : fmt::format("{}: {}", error.text, std::strerror(error.os_errno));
}

ModbusTcpClient connect(const std::string& host, std::uint16_t port) {
  Result<ModbusTcpClient> client = ModbusTcpClient::connect(host, port, kPatience);
  if (!client && client.error().os_errno == 0)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("--host {}: {}: check it, or give the address in numbers, as 192.168.1.20", host,
                                   client.error().text));
  if (!client)
    throw StartupError(
        ExitStatus::kWorkFailed,
        fmt::format(
            "no service answers at {} port {} ({}): is ninedotd running, with [modbus.tcp] in its configuration?", host,
            port, cause_of(client.error())));
  return std::move(*client);
}

}  // namespace

std::string cause_of(const Error& error) { return error.os_errno == 0 ? error.text : std::strerror(error.os_errno); }

ServiceClient::ServiceClient(const std::string& host, std::uint16_t port)
    : host_(host), port_(port), client_(connect(host, port)) {}

std::string ServiceClient::place() const { return fmt::format("{} port {}", host_, port_); }

void ServiceClient::fail(const std::string& what) const {
  throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", place(), what));
}

RegisterReader ServiceClient::read() {
  const Result<RegisterReader> reader = try_read();
  if (!reader) fail(with_cause(reader.error()));
  return *reader;
}

Result<void> ServiceClient::read_all() {
  const std::span<std::uint16_t> all(registers_);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (const Result<void> done = client_->read_registers(0, all.first(kFirstRead)); !done) return done;
    if (const Result<void> done = client_->read_registers(kFirstRead, all.subspan(kFirstRead)); !done) return done;
    if (registers_[reg::kPoseSequence] == registers_[reg::kPoseSequenceEnd]) break;
  }
  return {};
}

Result<RegisterReader> ServiceClient::try_read() {
  if (!client_) {
    Result<ModbusTcpClient> again = ModbusTcpClient::connect(host_, port_, kPatience);
    if (!again) return tl::unexpected<Error>(again.error());
    client_.emplace(std::move(*again));
  }
  if (const Result<void> done = read_all(); !done) {
    client_.reset();
    return tl::unexpected<Error>(done.error());
  }
  const RegisterReader reader = make_reader(registers_);
  if (!reader.is_ninedot())
    fail(fmt::format(
        "that is no ninedotd of this version (registers 0 and 1 read {:#06x} and {}): check --host and --port",
        registers_[0], registers_[1]));
  return reader;
}

void ServiceClient::write(std::uint16_t first, std::span<const std::uint16_t> values) {
  if (const Result<void> done = client_->write_registers(first, values); !done)
    fail(fmt::format("the command was refused ({})", cause_of(done.error())));
}

}  // namespace ninedot
