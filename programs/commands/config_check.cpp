#include "programs/commands/config_check.h"

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "drivers/modbus/rtu_server.h"
#include "drivers/modbus/tcp_server.h"
#include "drivers/posix/listening_program.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/modbus_options.h"
#include "programs/assembly/open_head.h"
#include "programs/assembly/open_source.h"
#include "programs/assembly/zoom_choice.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// A service that ends needs a moment from its last connection to its socket's end, and shows no descriptor in it.
constexpr auto kUntilItEnded = 1s;
constexpr auto kBetweenLooks = 50ms;

struct TcpPort {
  int error = 0;  ///< of listening there; 0: it is free
  Listening service = Listening::kNo;
};

TcpPort look_at(const ModbusTcpConfig& tcp) {
  const Result<void> free = try_listen(tcp.listen, tcp.port);
  if (free) return {};
  const int error = free.error().os_errno;
  return {error, error == EADDRINUSE ? find_listener("ninedotd", tcp.port) : Listening::kNo};
}

/// A service that is being restarted may let go of its port between the two halves of one look.
TcpPort settled(const ModbusTcpConfig& tcp) {
  const auto until = std::chrono::steady_clock::now() + kUntilItEnded;
  TcpPort port = look_at(tcp);
  while (port.error == EADDRINUSE && port.service == Listening::kNo && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(kBetweenLooks);
    port = look_at(tcp);
  }
  return port;
}

/// The first, because a running service explains what else is in use.
void check_modbus_tcp(const ModbusTcpConfig& tcp, ConfigFindings& findings) {
  const TcpPort port = settled(tcp);
  if (port.error == 0) return;
  if (port.service != Listening::kNo) {
    findings.note_running_service();
    findings.note("modbus.tcp.port",
                  fmt::format("{} port {} is in use{}", tcp.listen, tcp.port,
                              port.service == Listening::kYes
                                  ? " by a running ninedotd"
                                  : "; a ninedotd is running, which may be what has it: root sees whether it is"));
    return;
  }
  findings.refuse(
      port.error == EADDRNOTAVAIL ? "modbus.tcp.listen" : "modbus.tcp.port",
      fmt::format("{} port {}: {}{}", tcp.listen, tcp.port, std::strerror(port.error),
                  port.error == EADDRINUSE ? ": stop the program that uses it, or choose another port" : ""));
}

void check_devices(const Config& config, const ConfigProblems& problems, std::optional<CameraModel>& camera,
                   ConfigFindings& findings) {
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
    const OpenedSource opened =
        open_source(config, FrameDemand::kEveryFrame, calibration ? &calibration->record : nullptr);
    tells_zoom |= opened.tells_zoom;
    findings.note_camera(opened.description);
    is_opened = true;
  });
  if (is_recording && is_opened && config.camera.calibration.empty()) findings.attempt("camera.calibration", read);
  if (calibration && (is_opened || !is_recording) && can_be_made)
    findings.attempt("pan_tilt.zoom", [&] { choose_zoom(*calibration, config.pan_tilt, tells_zoom); });
  if (calibration) camera = calibration->camera;
  check_head(config, [&](const char* key, const std::function<void()>& step) { findings.attempt(key, step); });
}

}  // namespace

void check_as_the_service(const Config& config, const ConfigProblems& problems, ConfigFindings& findings,
                          std::optional<CameraModel>& camera) {
  check_file(config, problems, findings);
  // What could not be read says nothing of devices.
  if (problems.can_be_read && !problems.is_in("camera")) check_devices(config, problems, camera, findings);
}

std::vector<std::string> problem_lines(const std::vector<ConfigProblem>& problems, const std::string& name) {
  std::vector<std::string> lines;
  for (const ConfigProblem& problem : problems) lines.push_back(problem_text(name, problem));
  return lines;
}

}  // namespace ninedot
