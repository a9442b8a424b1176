// `ninedot aim`: points the head of a running service, or lets it follow again, as any Modbus client could.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "base/startup_error.h"
#include "programs/commands/commands.h"
#include "programs/commands/service_client.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kAnswerTakes = 2s;  // from the command to its acknowledge
constexpr int kStandsStill = 20;   // reads, 50 ms apart: heads on serial lines tell where they stand ten times a second
constexpr double kThere_deg = 0.15;  // the registers' own step is 0.01 deg; servos are calibrated no better

struct AimArguments {
  std::string host = "127.0.0.1";
  std::uint16_t port = 1502;
  std::optional<double> pan_deg, tilt_deg;
  bool follow = false;
  double wait_s = 10;
};

void send(ServiceClient& service, const AimArguments& arguments, const RegisterReader& before) {
  const auto set_point = [&](std::uint16_t address, const std::optional<double>& wanted_deg, std::uint16_t now) {
    std::array<std::uint16_t, 1> word{};
    encode_value(*find_register(address), wanted_deg.value_or(before.value(now)), {}, word);
    return word[0];
  };
  if (!arguments.follow) {
    const std::array<std::uint16_t, 2> points{set_point(reg::kPanSetPoint, arguments.pan_deg, reg::kPan),
                                              set_point(reg::kTiltSetPoint, arguments.tilt_deg, reg::kTilt)};
    service.write(reg::kPanSetPoint, points);
  }
  const auto sequence = static_cast<std::uint16_t>(before.integer(reg::kCommandSequence) + 1);
  const auto code = static_cast<std::uint16_t>(arguments.follow ? Command::kFollow : Command::kPoint);
  service.write(reg::kCommand, std::array<std::uint16_t, 2>{code, sequence});
  const auto until = std::chrono::steady_clock::now() + kAnswerTakes;
  while (service.read().integer(reg::kCommandAcknowledge) != sequence) {
    if (std::chrono::steady_clock::now() > until) service.fail("the command was taken, but is not finished");
    std::this_thread::sleep_for(20ms);
  }
}

bool is_there(const RegisterReader& r, const AimArguments& arguments) {
  const auto is_near = [&](std::uint16_t address, const std::optional<double>& wanted_deg) {
    return !wanted_deg || std::abs(r.value(address) - *wanted_deg) <= kThere_deg;
  };
  return is_near(reg::kPan, arguments.pan_deg) && is_near(reg::kTilt, arguments.tilt_deg);
}

std::string place_text(const RegisterReader& r) {
  return fmt::format("pan {:.2f} deg, tilt {:.2f} deg", r.value(reg::kPan), r.value(reg::kTilt));
}

void wait_until_there(ServiceClient& service, const AimArguments& arguments) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(arguments.wait_s);
  const bool is_terminal = ::isatty(STDERR_FILENO) != 0;
  std::string before;
  int stood_still = 0;  // reads in a row
  for (;;) {
    const RegisterReader r = service.read();
    stood_still = place_text(r) == std::exchange(before, place_text(r)) ? stood_still + 1 : 0;
    if (is_terminal) fmt::print(stderr, "\r{}   ", place_text(r));
    const bool arrived = is_there(r, arguments),
               is_at_end = r.status(status_bit::kServoLimit) && stood_still >= kStandsStill,
               late = is_at_end || std::chrono::steady_clock::now() > until;
    if (is_terminal && (arrived || late)) fmt::print(stderr, "\r{:40}\r", "");
    if (arrived) return fmt::print("{}\n", place_text(r));
    if (late)
      service.fail(fmt::format("the head stands at {}{}", place_text(r),
                               r.status(status_bit::kInhibited)    ? ": the inhibit input keeps it there"
                               : r.status(status_bit::kServoFault) ? ": it does not answer"
                               : r.status(status_bit::kServoLimit) ? ", the end of its range"
                                                                   : " and is not there yet"));
    std::this_thread::sleep_for(50ms);
  }
}

void run_aim(const AimArguments& arguments) {
  if (arguments.follow == (arguments.pan_deg || arguments.tilt_deg))
    throw StartupError(ExitStatus::kWrongUsage, "say either --follow, or where to: --pan-deg and --tilt-deg");
  ServiceClient service(arguments.host, arguments.port);
  const RegisterReader before = service.read();
  if (!before.status(status_bit::kHasHead)) service.fail("the service has no head: set pan_tilt.driver");
  if (!before.status(status_bit::kWritesEnabled))
    service.fail("the service takes no commands: set modbus.allow_writes = true");
  send(service, arguments, before);
  if (arguments.follow) return fmt::print("the head follows the landmark\n");
  if (arguments.wait_s > 0) wait_until_there(service, arguments);
}

}  // namespace

void add_aim_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("aim", "Point the pan/tilt head of a running service");
  const auto arguments = std::make_shared<AimArguments>();
  command->add_option("--pan-deg", arguments->pan_deg, "angle, positive to the left; default: as it stands")
      ->check(CLI::Range(-180.0, 180.0));
  command->add_option("--tilt-deg", arguments->tilt_deg, "angle, positive upwards; default: as it stands")
      ->check(CLI::Range(-90.0, 90.0));
  command->add_flag("--follow", arguments->follow, "follow the landmark again");
  command->add_option("--wait-s", arguments->wait_s, "how long the head may take; 0 = do not wait; default: 10")
      ->check(CLI::Range(0.0, 3600.0));
  command->add_option("--host", arguments->host, "the service's address; default: 127.0.0.1");
  command->add_option("--port", arguments->port, "its Modbus TCP port; default: 1502");
  command->callback([arguments] { run_aim(*arguments); });
}

}  // namespace ninedot
