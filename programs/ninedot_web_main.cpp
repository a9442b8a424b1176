// The page, a process of its own: configuration -> tap -> messages -> browsers, and back: browsers -> jogger ->
// Modbus; and tap -> recorder -> disk, where it is asked for. To the service it is one client like any other.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/startup_error.h"
#include "config/config.h"
#include "config/config_checks.h"
#include "drivers/posix/service_manager.h"
#include "drivers/posix/signals.h"
#include "programs/assembly/input_files.h"
#include "programs/log_text.h"
#include "programs/program.h"
#include "programs/web/access.h"
#include "programs/web/apply_request.h"
#include "programs/web/calibration_desk.h"
#include "programs/web/child_job.h"
#include "programs/web/configuration_desk.h"
#include "programs/web/jogger.h"
#include "programs/web/live_json.h"
#include "programs/web/map_desk.h"
#include "programs/web/recorder.h"
#include "programs/web/web_server.h"

namespace ninedot {
namespace {

/// Of a map that was changed meanwhile the page shows the new one; of one that is wrong, the one before.
class NewestMap {
 public:
  explicit NewestMap(std::string config_path) : config_path_(std::move(config_path)) {}
  /// Landmarks with a place.
  std::string json() {
    read();
    return json_;
  }
  /// All that the configuration has.
  std::string landmarks() {
    read();
    return landmarks_;
  }

 private:
  void read() {
    const MonoTime now = mono_now();
    if (read_at_ && now - *read_at_ < std::chrono::seconds(2)) return;
    read_at_ = now;
    try {
      const Config config = read_config(config_path_);
      json_ = map_json(config), landmarks_ = landmarks_json(config);
    } catch (const StartupError&) {
      // The configuration's view says what is wrong with it.
    }
  }

  const std::string config_path_;
  std::optional<MonoTime> read_at_;
  std::string json_ = "[]", landmarks_ = "[]";
};

Config servable_config(const std::string& path) {
  Config config = read_config(path);
  if (!config.tap.enabled)
    throw StartupError(ExitStatus::kWrongUsage, path + ": the page needs the tap: write `enabled = true` under [tap]");
  return config;
}

void tell_address(const WebConfig& web, bool tls) {
  const bool is_v6 = web.listen.find(':') != std::string::npos;
  fmt::print(stderr, "ninedot-web: {}://{}:{}\n", tls ? "https" : "http", is_v6 ? "[" + web.listen + "]" : web.listen,
             web.port);
  if (!is_loopback(web.listen) && !tls)
    fmt::print(stderr,
               "ninedot-web: WARNING: without TLS the token and the pictures cross the network in the clear; "
               "give [web] a certificate and a key\n");
}

/// Until a signal comes, or the service runs with a new configuration. \return  whether that is why
bool serve(const Config& config, const std::string& config_path, const std::string& ninedot,
           const TerminationSignals& signals, ApplyRequest& request, ServiceManager& manager) {
  const WebConfig& web = config.web;
  NewestMap map(config_path);
  AccessRules rules;
  rules.tls = !web.certificate.empty();
  rules.names = web.names;
  if (!web.token_file.empty()) rules.token = read_token(web.token_file);
  Jogger jogger(jogger_options(config, !rules.token.empty()));
  Recorder recorder(recorder_options(config, !rules.token.empty()));
  ConfigurationDesk desk(config_path, request);
  ChildJob job(ninedot);
  CalibrationDesk calibrations(calibration_desk_options(config, config_path, !rules.token.empty()), job, request);
  MapDeskOptions map_options = map_desk_options(config, config_path, !rules.token.empty());
  map_options.folder_of = [&](std::string_view name) { return recorder.folder_of(name); };
  map_options.landmarks = [&] { return map.landmarks(); };
  MapDesk maps(std::move(map_options), job, request);
  const WebServerOptions options{web,  config.tap.path, rules, [&] { return map.json(); }, jogger, recorder,
                                 desk, calibrations,    maps};
  WebServer server(options);
  tell_address(web, options.rules.tls);
  manager.ready();
  bool is_new = false;
  server.run([&] {
    is_new = request.takes_new_file(mono_now());
    return is_new || signals.wait(std::chrono::nanoseconds(0)) != 0;
  });
  return is_new;
}

/// The tool that was built, or installed, with this program.
std::string ninedot_beside_this() {
  std::error_code error;
  return (std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "ninedot").string();
}

void run_web(const std::string& config_path, const std::string& apply_socket, const std::string& ninedot) {
  Config config = servable_config(config_path);
  const TerminationSignals signals;  // before the first thread
  ServiceManager manager;
  ApplyRequest request(apply_socket);
  std::optional<Config> last;  // what the page was served by until now
  for (;;) {
    try {
      if (last) config = servable_config(config_path);
      if (!serve(config, config_path, ninedot, signals, request, manager)) break;
      last = config;
    } catch (const StartupError& error) {
      if (!last) throw;
      fmt::print(stderr, "ninedot-web: {}: the page goes on as it was\n", log_text(error.what()));
      if (!serve(*last, config_path, ninedot, signals, request, manager)) break;
    }
  }
  manager.stopping();
}

}  // namespace
}  // namespace ninedot

// NOLINTNEXTLINE(bugprone-exception-escape): CLI11 throws here for a mistake in the declarations below, before any run
int main(int argc, char** argv) {
  CLI::App app{"The page of a running ninedotd: what it sees, its health, its registers, its map.", "ninedot-web"};
  std::string config_path;
  app.add_option("--config", config_path, "the service's configuration: its [tap] and [web] are read")->required();
  std::string apply_socket = "/run/ninedot-apply.socket";
  app.add_option("--apply-socket", apply_socket, "where `ninedot apply --page` is reached")->capture_default_str();
  std::string tool = ninedot::ninedot_beside_this();
  app.add_option("--ninedot", tool, "the program that calibrates and builds maps; default: the one beside this");
  return ninedot::run_program(app, argc, argv, [&] { ninedot::run_web(config_path, apply_socket, tool); });
}
