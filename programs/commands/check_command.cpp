// `ninedot check`: everything that the service would refuse at its start, without starting it, and what it would wait
// for.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "programs/assembly/input_files.h"
#include "programs/commands/commands.h"
#include "programs/commands/config_check.h"
#include "programs/startup_errors.h"

namespace ninedot {
namespace {

/// \param camera  nothing where no calibration was read \param agreed  with the camera; empty: it was not opened
void print_summary(const Config& config, const std::optional<CameraModel>& camera, const std::string& agreed) {
  fmt::print("  camera    {}{}{}, {}x{} px, {} Hz{}\n", config.camera.source, config.camera.device.empty() ? "" : " ",
             config.camera.device, config.camera.width_px, config.camera.height_px, config.camera.rate_hz,
             camera ? fmt::format(", f = {:.1f} px", camera->fx_px) : "");
  if (!agreed.empty()) fmt::print("  agreed    {}\n", agreed);
  fmt::print("  landmark  ring radius {} mm, dots {} mm, centre dot {} mm\n", config.landmark.ring_radius_mm,
             config.landmark.dot_diameter_mm, config.landmark.centre_diameter_mm);
  fmt::print("  pose      solver {}\n", config.pose.solver);
  if (config.pan_tilt.driver != "none")
    fmt::print("  pan/tilt  {}, pan {} to {} deg, tilt {} to {} deg\n", config.pan_tilt.driver,
               config.pan_tilt.pan.min_deg, config.pan_tilt.pan.max_deg, config.pan_tilt.tilt.min_deg,
               config.pan_tilt.tilt.max_deg);
  if (config.modbus_tcp.enabled)
    fmt::print("  modbus    TCP {} port {}\n", config.modbus_tcp.listen, config.modbus_tcp.port);
  if (config.modbus_rtu.enabled)
    fmt::print("  modbus    RTU {} {} baud, parity {}, unit {}\n", config.modbus_rtu.device, config.modbus_rtu.baud,
               config.modbus_rtu.parity, config.modbus_rtu.unit);
  if (!config.modbus_tcp.enabled && !config.modbus_rtu.enabled)
    fmt::print("  modbus    none: add [modbus.tcp] or [modbus.rtu] to be read\n");
}

void run_check(const std::string& path, bool file_only) {
  ConfigProblems problems;
  const Config config = read_config(path, problems);
  ConfigFindings findings(problems);
  std::optional<CameraModel> camera;
  if (file_only) {
    check_file(config, problems, findings);
    check_camera_keys(config, problems, findings);
  } else {
    check_as_the_service(config, problems, findings, camera);
  }
  const std::vector<std::string> refused = problem_lines(findings.problems(), path);
  if (refused.empty()) {
    fmt::print("{}: ok\n", path);
    print_summary(config, camera, findings.camera());
  } else if (!findings.camera().empty()) {
    fmt::print("  agreed    {}\n", findings.camera());
  }
  for (const ConfigProblem& note : findings.notes())
    fmt::print("{}\n", problem_text(path, {note.line, "note: " + note.what, note.file}));
  if (!refused.empty()) throw StartupErrors(refused);
}

}  // namespace

void add_check_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "check", "Say what the service would refuse about a configuration, and what it would wait for");
  const auto path = std::make_shared<std::string>();
  command->add_option("--config", *path, "configuration file")->required();
  const auto file_only = std::make_shared<bool>(false);
  command->add_flag("--file-only", *file_only,
                    "look at the configuration file alone: at no device, port or other file");
  command->callback([path, file_only] { run_check(*path, *file_only); });
}

}  // namespace ninedot
