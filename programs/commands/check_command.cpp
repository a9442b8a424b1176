// `ninedot check`: everything that the service would refuse at its start, without starting it. It asks the same
// functions as the service; ports and serial lines are only looked at, because a running service may be using them.
#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <string>

#include "base/startup_error.h"
#include "config/config_checks.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/open_head.h"
#include "programs/assembly/open_source.h"
#include "programs/commands/commands.h"

namespace ninedot {
namespace {

/// Binds the address for an instant. \return  errno, 0 = free
int try_to_bind(const std::string& address, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) return EADDRNOTAVAIL;
  const int descriptor = ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  int error = descriptor < 0 || ::bind(descriptor, found->ai_addr, found->ai_addrlen) != 0 ? errno : 0;
  // Two sockets may be bound alike with SO_REUSEADDR; only one may listen.
  if (error == 0 && ::listen(descriptor, 1) != 0) error = errno;
  if (descriptor >= 0) ::close(descriptor);
  ::freeaddrinfo(found);
  return error;
}

/// \return  what is wrong with a serial device, empty = nothing
std::string serial_problem(const std::string& device) {
  struct stat status {};
  if (::stat(device.c_str(), &status) != 0) return std::strerror(errno);
  if (!S_ISCHR(status.st_mode)) return "is no serial device";
  return ::access(device.c_str(), R_OK | W_OK) == 0 ? "" : std::strerror(errno);
}

/// Refusals of one key become "FILE:LINE: what".
class Refusals {
 public:
  Refusals(const std::string& path, const ConfigProblems& problems) : path_(path), problems_(problems) {}

  [[noreturn]] void refuse(const char* key, const std::string& what) const {
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}:{}: {}", path_, problems_.line_of(key), what));
  }
  /// Does what the service does at its start, for the key that it is about.
  void attempt(const char* key, const std::function<void()>& step) const {
    try {
      step();
    } catch (const StartupError& error) {
      refuse(key, error.what());
    }
  }

 private:
  const std::string& path_;
  const ConfigProblems& problems_;
};

void check_modbus(const Config& config, const Refusals& refusals) {
  if (config.modbus_tcp.enabled)
    if (const int error = try_to_bind(config.modbus_tcp.listen, config.modbus_tcp.port); error != 0)
      refusals.refuse(
          error == EADDRNOTAVAIL ? "modbus.tcp.listen" : "modbus.tcp.port",
          fmt::format("{} port {}: {}{}", config.modbus_tcp.listen, config.modbus_tcp.port, std::strerror(error),
                      error == EADDRINUSE ? ": stop the program that uses it, or choose another port" : ""));
  if (config.modbus_rtu.enabled)
    if (const std::string problem = serial_problem(config.modbus_rtu.device); !problem.empty())
      refusals.refuse("modbus.rtu.device", fmt::format("{}: {}", config.modbus_rtu.device, problem));
}

void run_check(const std::string& path) {
  ConfigProblems problems;
  const Config config = read_config(path, problems);
  const Refusals refusals(path, problems);
  CameraModel camera;
  refusals.attempt("camera.source", [&] { check_source(config.camera); });
  refusals.attempt("camera.device", [&] { open_source(config.camera, FrameDemand::kEveryFrame); });
  refusals.attempt("camera.calibration", [&] { camera = read_camera_calibration(config.camera); });
  refusals.attempt("landmarks", [&] { static_cast<void>(localiser_options(config)); });
  check_head(config, [&](const char* key, const std::function<void()>& step) { refusals.attempt(key, step); });
  check_modbus(config, refusals);

  fmt::print("{}: ok\n", path);
  fmt::print("  camera    {} {}, {}x{} px, {} Hz, f = {:.1f} px\n", config.camera.source, config.camera.device,
             camera.width_px, camera.height_px, config.camera.rate_hz, camera.fx_px);
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

}  // namespace

void add_check_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("check", "Say what the service would refuse about a configuration");
  const auto path = std::make_shared<std::string>();
  command->add_option("--config", *path, "configuration file")->required();
  command->callback([path] { run_check(*path); });
}

}  // namespace ninedot
