// `ninedot aim`: points the head of a running service, parks it, or lets it follow again, as any Modbus client could.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "base/startup_error.h"
#include "programs/commands/commands.h"
#include "programs/commands/head_client.h"
#include "programs/commands/named_option.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kFollowingTakes = 5s;  // at most; a head that answers follows at the next frame
constexpr auto kBetweenReads = 50ms;

struct AimArguments {
  std::string host = "127.0.0.1";
  std::uint16_t port = 1502;
  std::optional<double> pan_deg, tilt_deg;
  bool follow = false, park = false;
  double wait_s = 10;
};

/// CLI::Range lets NaN pass: it asks whether a number lies outside.
std::string refuse_nan(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? text + " is no number" : std::string();
}

std::string place_text(const RegisterReader& r) {
  return fmt::format("pan {:.2f} deg, tilt {:.2f} deg", r.value(reg::kPan), r.value(reg::kTilt));
}

std::string failure_text(const RegisterReader& r, bool is_over) {
  const std::string place = fmt::format("the head stands at {}", place_text(r));
  if (r.status(status_bit::kInhibited)) return place + ": the inhibit input keeps it there";
  if (r.status(status_bit::kServoFault)) return place + ": it does not answer";
  if (r.status(status_bit::kServoLimit)) return place + ", the end of its range";
  return place + (is_over ? " and did not get there" : " and is not there yet");
}

/// Shows on a terminal where the head stands meanwhile. Throws StartupError: failed, superseded, or too late.
RegisterReader wait_until_done(HeadClient& head, std::chrono::duration<double> wait) {
  const auto until = std::chrono::steady_clock::now() + wait;
  const bool is_terminal = ::isatty(STDERR_FILENO) != 0;
  const auto clear = [is_terminal] {
    if (is_terminal) fmt::print(stderr, "\r{:40}\r", "");
  };
  for (;;) {
    const RegisterReader r = head.read();
    if (is_terminal) fmt::print(stderr, "\r{}   ", place_text(r));
    const std::optional<CommandResult> result = head.result(r);
    const bool is_over = result != CommandResult::kRunning;
    if (!is_over && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(kBetweenReads);
      continue;
    }
    clear();
    if (!result) head.fail("another client's command took the place of this one");
    if (result != CommandResult::kDone) head.fail(failure_text(r, is_over));
    return r;
  }
}

void run_aim(const AimArguments& arguments) {
  const bool points = arguments.pan_deg || arguments.tilt_deg;
  if (int{arguments.follow} + int{arguments.park} + int{points} != 1)
    throw StartupError(ExitStatus::kWrongUsage, "say either --follow, --park, or where to: --pan-deg and --tilt-deg");
  HeadClient head(arguments.host, arguments.port);
  if (arguments.follow) {
    head.follow();
    wait_until_done(head, kFollowingTakes);
    return fmt::print("the head follows the landmark\n");
  }
  if (arguments.park)
    head.park();
  else
    head.point(arguments.pan_deg, arguments.tilt_deg);
  if (arguments.wait_s <= 0) return;
  fmt::print("{}\n", place_text(wait_until_done(head, std::chrono::duration<double>(arguments.wait_s))));
}

}  // namespace

void add_aim_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("aim", "Point the pan/tilt head of a running service");
  const auto arguments = std::make_shared<AimArguments>();
  command->add_option("--pan-deg", arguments->pan_deg, "angle, positive to the left; default: as it stands")
      ->check(CLI::Range(-180.0, 180.0))
      ->check(refuse_nan);
  command->add_option("--tilt-deg", arguments->tilt_deg, "angle, positive upwards; default: as it stands")
      ->check(CLI::Range(-90.0, 90.0))
      ->check(refuse_nan);
  command->add_flag("--follow", arguments->follow, "follow the landmark again");
  command->add_flag("--park", arguments->park, "go to the parking place and stay there");
  command->add_option("--wait-s", arguments->wait_s, "how long the head may take; 0 = do not wait; default: 10")
      ->check(CLI::Range(0.0, 3600.0))
      ->check(refuse_nan);
  command->add_option("--host", arguments->host, "the service's address; default: 127.0.0.1")->check(is_named());
  command->add_option("--port", arguments->port, "its Modbus TCP port; default: 1502");
  command->callback([arguments] { run_aim(*arguments); });
}

}  // namespace ninedot
