// `ninedot calibrate`: one sub-command per thing that can be calibrated, each in a file of its own.
#include <CLI/CLI.hpp>

#include "programs/commands/calibrate_commands.h"
#include "programs/commands/commands.h"

namespace ninedot {

void add_calibrate_command(CLI::App& app) {
  CLI::App* group = app.add_subcommand("calibrate", "Find out the numbers of a camera, its shutter and its head");
  group->require_subcommand(1);
  add_calibrate_camera_command(*group);
  add_calibrate_ellipse_command(*group);
  add_calibrate_pan_tilt_command(*group);
  add_calibrate_rolling_shutter_command(*group);
  add_calibrate_zoom_command(*group);
}

}  // namespace ninedot
