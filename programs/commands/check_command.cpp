// `ninedot check`: everything that the service would refuse at its start, without starting it, and what it would wait
// for. It asks the same functions as the service; ports and serial lines are only looked at, because a running service
// may be using them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/one_line.h"
#include "base/startup_error.h"
#include "config/config_checks.h"
#include "drivers/camera/camera_device.h"
#include "drivers/modbus/rtu_server.h"
#include "drivers/modbus/tcp_server.h"
#include "drivers/posix/late_device.h"
#include "drivers/posix/listening_program.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/modbus_options.h"
#include "programs/assembly/open_head.h"
#include "programs/assembly/open_source.h"
#include "programs/assembly/zoom_choice.h"
#include "programs/commands/commands.h"

namespace ninedot {
namespace {

/// What is found about one file: problems, which the service refuses, and notes about what it waits for.
class Findings {
 public:
  Findings(const std::string& path, const ConfigProblems& problems) : path_(path), file_(problems) {
    for (const ConfigProblem& problem : file_.list) problems_.push_back(problem);
  }

  void refuse(const char* key, const std::string& what) { problems_.push_back({file_.line_of(key), what, {}}); }
  void note(const char* key, const std::string& what) { notes_.push_back({file_.line_of(key), what, {}}); }

  /// Does what the service does at its start, for the key that it is about. Not for a table with mistakes in the file:
  /// there the key may not have been read at all.
  void attempt(const char* key, const std::function<void()>& step) {
    if (file_.is_in(std::string_view(key).substr(0, std::string_view(key).find('.')))) return;
    try {
      step();
    } catch (const DeviceAbsent& absent) {
      note_absent(key, absent.what());
    } catch (const CameraRefused& camera) {
      if (is_absent(camera.os_errno))
        note_absent(key, camera.what());
      else
        refuse(key, camera.what());
    } catch (const StartupError& error) {
      refuse(key, error.what());
    }
  }

  /// A ninedotd runs on this file's port: then it is the one that has the devices.
  void note_running_service() { is_service_running_ = true; }

  /// Throws StartupError(kWrongUsage), a line for each problem; else prints the notes after `summary`.
  void conclude(const std::function<void()>& summary) {
    std::ranges::stable_sort(problems_, {}, &ConfigProblem::place);
    std::string lines;
    for (const ConfigProblem& problem : problems_) lines += (lines.empty() ? "" : "\n") + problem_text(path_, problem);
    if (problems_.empty()) summary();
    std::ranges::stable_sort(notes_, {}, &ConfigProblem::place);
    for (const ConfigProblem& note : notes_)
      fmt::print("{}\n", problem_text(path_, {note.line, "note: " + note.what, {}}));
    if (!problems_.empty()) throw StartupError(ExitStatus::kWrongUsage, lines);
  }

 private:
  /// Of a camera: not there, busy, not permitted, or without a signal. Anything else is a setting that it does not
  /// have.
  static bool is_absent(int error) {
    for (const int mended : {ENOENT, ENODEV, ENXIO, EBUSY, EACCES, EPERM, ENOLINK})
      if (error == mended) return true;
    return false;
  }
  void note_absent(const char* key, const std::string& what) {
    note(key,
         is_service_running_ ? "a ninedotd is running, which may be what has it: " + what : "waits for it: " + what);
  }

  const std::string& path_;
  const ConfigProblems& file_;
  std::vector<ConfigProblem> problems_, notes_;
  bool is_service_running_ = false;
};

/// The first, because a running service explains what else is in use.
void check_modbus_tcp(const ModbusTcpConfig& tcp, Findings& findings) {
  const Result<void> free = try_listen(tcp.listen, tcp.port);
  if (free) return;
  const int error = free.error().os_errno;
  const Listening service = error == EADDRINUSE ? find_listener("ninedotd", tcp.port) : Listening::kNo;
  if (service != Listening::kNo) {
    findings.note_running_service();
    findings.note("modbus.tcp.port",
                  fmt::format("{} port {} is in use{}", tcp.listen, tcp.port,
                              service == Listening::kYes
                                  ? " by a running ninedotd"
                                  : "; a ninedotd is running, which may be what has it: root sees whether it is"));
    return;
  }
  findings.refuse(error == EADDRNOTAVAIL ? "modbus.tcp.listen" : "modbus.tcp.port",
                  fmt::format("{} port {}: {}{}", tcp.listen, tcp.port, std::strerror(error),
                              error == EADDRINUSE ? ": stop the program that uses it, or choose another port" : ""));
}

/// \param camera  nothing where no calibration was read
void print_summary(const Config& config, const std::optional<CameraModel>& camera) {
  fmt::print("  camera    {}{}{}, {}x{} px, {} Hz{}\n", config.camera.source, config.camera.device.empty() ? "" : " ",
             config.camera.device, config.camera.width_px, config.camera.height_px, config.camera.rate_hz,
             camera ? fmt::format(", f = {:.1f} px", camera->fx_px) : "");
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

void check_devices(const Config& config, const ConfigProblems& problems, std::optional<CameraModel>& camera,
                   Findings& findings) {
  if (config.modbus_tcp.enabled && !problems.is_in("modbus")) check_modbus_tcp(config.modbus_tcp, findings);
  if (config.modbus_rtu.enabled)
    findings.attempt("modbus.rtu.device", [&] { check_rtu_line(modbus_options(config).rtu.value()); });
  // A recording that is not there has no calibration either; that is no second mistake.
  const bool is_recording = config.camera.source == "recording";
  std::optional<CameraCalibration> calibration;
  const auto read = [&] { calibration = read_camera_calibration(config.camera); };
  if (!is_recording || !config.camera.calibration.empty()) findings.attempt("camera.calibration", read);
  bool is_opened = false, tells_zoom = head_tells_zoom(config.pan_tilt);
  // A simulated camera is made of the head and the robot as well: from a mistake in those nothing can be made.
  const bool can_be_made = config.camera.source != "simulated" ||
                           !(problems.is_in("pan_tilt") || problems.is_in("body") || problems.is_in("simulation"));
  findings.attempt("camera.device", [&] {
    if (!can_be_made) return;
    tells_zoom |=
        open_source(config, FrameDemand::kEveryFrame, calibration ? &calibration->record : nullptr).tells_zoom;
    is_opened = true;
  });
  if (is_recording && is_opened && config.camera.calibration.empty()) findings.attempt("camera.calibration", read);
  if (calibration && (is_opened || !is_recording) && can_be_made)
    findings.attempt("pan_tilt.zoom", [&] { choose_zoom(*calibration, config.pan_tilt, tells_zoom); });
  if (calibration) camera = calibration->camera;
  check_head(config, [&](const char* key, const std::function<void()>& step) { findings.attempt(key, step); });
}

/// What the service asks of the camera's keys before it looks at anything else; check_devices finds the same.
void check_camera_keys(const CameraConfig& camera, Findings& findings) {
  findings.attempt("camera.device", [&] { check_device_named(camera); });
  // Without a recording there is no calibration of its own either; that is no second mistake.
  if (camera.source != "recording" && camera.source != "simulated")
    findings.attempt("camera.calibration", [&] { calibration_file(camera); });
}

void run_check(const std::string& path, bool file_only) {
  ConfigProblems problems;
  const Config config = read_config(path, problems);
  Findings findings(path, problems);
  std::optional<CameraModel> camera;
  if (problems.can_be_read) findings.attempt("landmarks", [&] { static_cast<void>(localiser_options(config)); });
  if (!config.camera.wait_for_device)
    findings.note("camera.wait_for_device", "without effect: the service always waits for its camera; remove it");
  // What could not be read says nothing of devices.
  if (problems.can_be_read && !problems.is_in("camera")) {
    if (file_only)
      check_camera_keys(config.camera, findings);
    else
      check_devices(config, problems, camera, findings);
  }
  findings.conclude([&] {
    fmt::print("{}: ok\n", path);
    print_summary(config, camera);
  });
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
