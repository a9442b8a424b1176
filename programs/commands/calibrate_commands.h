#pragma once
/// The sub-commands of `ninedot calibrate`, one translation unit each.
namespace CLI {
class App;
}

namespace ninedot {

void add_calibrate_camera_command(CLI::App& group);
void add_calibrate_ellipse_command(CLI::App& group);
void add_calibrate_pan_tilt_command(CLI::App& group);
void add_calibrate_rolling_shutter_command(CLI::App& group);
void add_calibrate_zoom_command(CLI::App& group);

}  // namespace ninedot
