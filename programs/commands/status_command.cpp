// `ninedot status`: what a running service says about itself, asked like any other Modbus client.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <string>

#include "drivers/posix/signals.h"
#include "programs/commands/commands.h"
#include "programs/commands/service_client.h"
#include "programs/display/live_display.h"
#include "programs/display/status_view.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct StatusArguments {
  std::string host = "127.0.0.1";
  std::uint16_t port = 1502;
  bool watch = false, json = false;
};

void watch(ServiceClient& service, const StatusArguments& arguments) {
  const TerminationSignals signals;
  LiveDisplay display(stdout, {"", "Ctrl-C ends"});
  while (signals.wait(50ms) == 0 && std::ferror(stdout) == 0 && !display.is_broken()) {
    const RegisterReader reader = service.read();
    if (arguments.json) {
      fmt::print("{}\n", status_json(reader));
      std::fflush(stdout);
      if (signals.wait(950ms) != 0) break;
    } else {
      display.show(reader, {}, mono_now());
    }
  }
}

void run_status(const StatusArguments& arguments) {
  ServiceClient service(arguments.host, arguments.port);
  if (arguments.watch) return watch(service, arguments);
  const RegisterReader reader = service.read();
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
