// The command-line tool: one sub-command per task, each in its own file. Exit status 0 success, 1 the work failed,
// 2 wrong usage or configuration.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "app/commands.h"
#include "base/startup_error.h"

int main(int argc, char** argv) {
  using namespace ninedot;
  CLI::App app{"Camera pose from a nine-dot landmark: the tools around ninedotd.", "ninedot"};
  app.set_version_flag("--version", "ninedot " NINEDOT_VERSION);
  app.require_subcommand(1);
  app.footer("'ninedot COMMAND --help' tells more. Exit status: 0 success, 1 the work failed, 2 wrong usage or configuration.");
  add_replay_command(app);
  add_record_command(app);
  add_pattern_command(app);
  add_check_command(app);
  add_registers_command(app);
  add_status_command(app);
  try {
    app.parse(argc, argv);
    return static_cast<int>(ExitStatus::kSuccess);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "ninedot: {}: see 'ninedot --help'\n", error.what());
    return static_cast<int>(ExitStatus::kWrongUsage);
  } catch (const StartupError& error) {
    fmt::print(stderr, "ninedot: {}\n", error.what());
    return static_cast<int>(error.status);
  } catch (const std::exception& error) {
    fmt::print(stderr, "ninedot: {}\n", error.what());
    return static_cast<int>(ExitStatus::kWorkFailed);
  }
}
