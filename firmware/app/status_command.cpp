// `ninedot status`: what a running service says about itself, asked like any other Modbus client.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>

#include "app/commands.h"
#include "app/live_display.h"
#include "app/status_view.h"
#include "base/startup_error.h"
#include "drivers/modbus/client.h"
#include "drivers/posix/signals.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct StatusArguments {
  std::string host = "127.0.0.1";
  std::uint16_t port = 1502;
  bool watch = false, json = false;
};

RegisterBlock read_service(ModbusTcpClient& client, const StatusArguments& arguments) {
  RegisterBlock registers{};
  if (const Result<void> read = client.read_registers(0, registers); !read)
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{} port {}: {}: {}", arguments.host, arguments.port,
                                                            read.error().text, std::strerror(read.error().os_errno)));
  if (!RegisterReader(registers).is_ninedot())
    throw StartupError(
        ExitStatus::kWorkFailed,
        fmt::format("{} port {}: that is no ninedotd of this version (registers 0 and 1 read {:#06x} and "
                    "{}): check --host and --port",
                    arguments.host, arguments.port, registers[0], registers[1]));
  return registers;
}

void watch(ModbusTcpClient& client, const StatusArguments& arguments) {
  const TerminationSignals signals;
  LiveDisplay display(stdout, {"", "Ctrl-C ends"});
  while (signals.wait(50ms) == 0 && std::ferror(stdout) == 0) {
    const RegisterBlock registers = read_service(client, arguments);
    if (arguments.json) {
      fmt::print("{}\n", status_json(make_reader(registers)));
      std::fflush(stdout);
      if (signals.wait(950ms) != 0) break;
    } else {
      display.show(make_reader(registers), {}, mono_now());
    }
  }
}

void run_status(const StatusArguments& arguments) {
  Result<ModbusTcpClient> client = ModbusTcpClient::connect(arguments.host, arguments.port, 2s);
  if (!client)
    throw StartupError(
        ExitStatus::kWorkFailed,
        fmt::format("no service answers at {} port {} ({}): is ninedotd running, with [modbus.tcp] in its "
                    "configuration?",
                    arguments.host, arguments.port, std::strerror(client.error().os_errno)));
  if (arguments.watch) return watch(*client, arguments);
  const RegisterBlock registers = read_service(*client, arguments);
  const RegisterReader reader = make_reader(registers);
  fmt::print("{}", arguments.json ? status_json(reader) + "\n" : status_table(reader));
}

}  // namespace

void add_status_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("status", "Show what a running service does: pose, rate, latency, health");
  const auto arguments = std::make_shared<StatusArguments>();
  command->add_option("--host", arguments->host, "its address; default: 127.0.0.1");
  command->add_option("--port", arguments->port, "its Modbus TCP port; default: 1502");
  command->add_flag("--watch", arguments->watch, "go on until Ctrl-C");
  command->add_flag("--json", arguments->json, "one JSON object on one line, with --watch one a second");
  command->callback([arguments] { run_status(*arguments); });
}

}  // namespace ninedot
