// The command-line tool: one sub-command per task, each in its own file. Exit status 0 success, 1 the work failed,
// 2 wrong usage or configuration.
#include <CLI/CLI.hpp>

#include "programs/commands/commands.h"
#include "programs/program.h"

// NOLINTNEXTLINE(bugprone-exception-escape): CLI11 throws here for a mistake in the declarations below, before any run
int main(int argc, char** argv) {
  CLI::App app{"Camera pose from a nine-dot landmark: the tools around ninedotd.", "ninedot"};
  app.require_subcommand(1);
  app.footer(
      "'ninedot COMMAND --help' tells more. Exit status: 0 success, 1 the work failed, 2 wrong usage or "
      "configuration.");
  ninedot::add_replay_command(app);
  ninedot::add_record_command(app);
  ninedot::add_cameras_command(app);
  ninedot::add_pattern_command(app);
  ninedot::add_check_command(app);
  ninedot::add_apply_command(app);
  ninedot::add_registers_command(app);
  ninedot::add_status_command(app);
  ninedot::add_aim_command(app);
  ninedot::add_map_command(app);
  ninedot::add_tap_command(app);
  ninedot::add_simulate_command(app);
  ninedot::add_calibrate_command(app);
  return ninedot::run_program(app, argc, argv);
}
