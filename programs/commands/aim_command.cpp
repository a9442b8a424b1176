// `ninedot aim`: points the head of a running service, parks it, or lets it follow again, as any Modbus client could.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "base/startup_error.h"
#include "programs/commands/commands.h"
#include "programs/commands/service_client.h"

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

/// \return  the sequence number by which its result is known
std::uint16_t send(ServiceClient& service, const AimArguments& arguments, const RegisterReader& before) {
  const auto set_point = [&](std::uint16_t address, const std::optional<double>& wanted_deg, std::uint16_t now) {
    std::array<std::uint16_t, 1> word{};
    encode_value(*find_register(address), wanted_deg.value_or(before.value(now)), {}, word);
    return word[0];
  };
  const auto sequence = static_cast<std::uint16_t>(before.integer(reg::kCommandSequence) + 1);
  if (!arguments.follow && !arguments.park) {
    const std::array<std::uint16_t, 2> points{set_point(reg::kPanSetPoint, arguments.pan_deg, reg::kPan),
                                              set_point(reg::kTiltSetPoint, arguments.tilt_deg, reg::kTilt)};
    service.write(reg::kPanSetPoint, points);
  }
  const auto code = static_cast<std::uint16_t>(arguments.follow ? Command::kFollow
                                               : arguments.park ? Command::kPark
                                                                : Command::kPoint);
  service.write(reg::kCommand, std::array<std::uint16_t, 2>{code, sequence});
  return sequence;
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
RegisterReader wait_until_done(ServiceClient& service, std::uint16_t sequence, std::chrono::duration<double> wait) {
  const auto until = std::chrono::steady_clock::now() + wait;
  const bool is_terminal = ::isatty(STDERR_FILENO) != 0;
  const auto clear = [is_terminal] {
    if (is_terminal) fmt::print(stderr, "\r{:40}\r", "");
  };
  for (;;) {
    const RegisterReader r = service.read();
    if (is_terminal) fmt::print(stderr, "\r{}   ", place_text(r));
    const auto result = static_cast<CommandResult>(r.integer(reg::kCommandResult));
    const bool is_ours = r.integer(reg::kCommandSequence) == sequence;
    const bool is_over = result != CommandResult::kRunning;
    if (is_ours && !is_over && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(kBetweenReads);
      continue;
    }
    clear();
    if (!is_ours) service.fail("another client's command took the place of this one");
    if (result != CommandResult::kDone) service.fail(failure_text(r, is_over));
    return r;
  }
}

void run_aim(const AimArguments& arguments) {
  const bool points = arguments.pan_deg || arguments.tilt_deg;
  if (int{arguments.follow} + int{arguments.park} + int{points} != 1)
    throw StartupError(ExitStatus::kWrongUsage, "say either --follow, --park, or where to: --pan-deg and --tilt-deg");
  ServiceClient service(arguments.host, arguments.port);
  const RegisterReader before = service.read();
  if (!before.status(status_bit::kHasHead)) service.fail("the service has no head: set pan_tilt.driver");
  if (!before.status(status_bit::kWritesEnabled))
    service.fail("the service takes no commands: set modbus.allow_writes = true");
  const std::uint16_t sequence = send(service, arguments, before);
  if (arguments.follow) {
    wait_until_done(service, sequence, kFollowingTakes);
    return fmt::print("the head follows the landmark\n");
  }
  if (arguments.wait_s <= 0) return;
  fmt::print("{}\n", place_text(wait_until_done(service, sequence, std::chrono::duration<double>(arguments.wait_s))));
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
  command->add_option("--host", arguments->host, "the service's address; default: 127.0.0.1");
  command->add_option("--port", arguments->port, "its Modbus TCP port; default: 1502");
  command->callback([arguments] { run_aim(*arguments); });
}

}  // namespace ninedot
