// `ninedot status`: what a running service says about itself, asked like any other Modbus client.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>

#include "drivers/posix/signals.h"
#include "programs/commands/commands.h"
#include "programs/commands/named_option.h"
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

/// On a terminal a table, else a line a second. A service that is lost is waited for, as is one that is restarted.
void watch(ServiceClient& service, const StatusArguments& arguments) {
  const TerminationSignals signals;
  const bool is_table = !arguments.json && ::isatty(STDOUT_FILENO) == 1;
  LiveDisplay display(stdout, {"", "Ctrl-C ends"});
  bool is_lost = false;
  do {
    const Result<RegisterReader> reader = service.try_read();
    if (!reader && !is_lost) {
      display.make_room();
      fmt::print(stderr, "ninedot: {}: lost the service ({}); waits for it\n", service.place(),
                 cause_of(reader.error()));
    }
    is_lost = !reader;
    if (reader && is_table) display.show(*reader, {}, mono_now());
    if (reader && !is_table) {
      fmt::print("{}\n", arguments.json ? status_json(*reader) : status_line(*reader));
      std::fflush(stdout);
    }
  } while (signals.wait(is_table && !is_lost ? 50ms : 1000ms) == 0 && std::ferror(stdout) == 0 && !display.is_broken());
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
  command->add_option("--host", arguments->host, "its address; default: 127.0.0.1")->check(is_named());
  command->add_option("--port", arguments->port, "its Modbus TCP port; default: 1502");
  command->add_flag("--watch", arguments->watch, "go on until Ctrl-C, also when the service is restarted");
  command->add_flag("--json", arguments->json, "one JSON object on one line, with --watch one a second");
  command->callback([arguments] { run_status(*arguments); });
}

}  // namespace ninedot
