#pragma once
/// The sub-commands of `ninedot`, one translation unit each. A command reports failure by throwing StartupError.
namespace CLI {
class App;
}

namespace ninedot {

void add_replay_command(CLI::App& app);
void add_record_command(CLI::App& app);
void add_cameras_command(CLI::App& app);
void add_pattern_command(CLI::App& app);
void add_check_command(CLI::App& app);
void add_apply_command(CLI::App& app);
void add_registers_command(CLI::App& app);
void add_status_command(CLI::App& app);
void add_aim_command(CLI::App& app);
void add_map_command(CLI::App& app);
void add_tap_command(CLI::App& app);
void add_simulate_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);

}  // namespace ninedot
