#include "programs/commands/head_client.h"

#include <array>

namespace ninedot {
namespace {

std::uint16_t word_of(std::uint16_t address, double value) {
  std::array<std::uint16_t, 1> word{};
  encode_value(*find_register(address), value, {}, word);
  return word[0];
}

}  // namespace

HeadClient::HeadClient(const std::string& host, std::uint16_t port) : service_(host, port) {
  const RegisterReader now = read();
  if (!now.status(status_bit::kHasHead)) fail("the service has no head: set pan_tilt.driver");
  if (!now.status(status_bit::kWritesEnabled)) fail("the service takes no commands: set modbus.allow_writes = true");
  sequence_ = static_cast<std::uint16_t>(now.integer(reg::kCommandSequence));
}

void HeadClient::point(std::optional<double> pan_deg, std::optional<double> tilt_deg) {
  if (!pan_deg || !tilt_deg) {
    const RegisterReader now = read();
    pan_deg = pan_deg.value_or(now.value(reg::kPan));
    tilt_deg = tilt_deg.value_or(now.value(reg::kTilt));
  }
  service_.write(reg::kPanSetPoint,
                 std::array{word_of(reg::kPanSetPoint, *pan_deg), word_of(reg::kTiltSetPoint, *tilt_deg)});
  command(Command::kPoint);
}

void HeadClient::command(Command command) {
  ++sequence_;
  service_.write(reg::kCommand, std::array{static_cast<std::uint16_t>(command), sequence_});
}

std::optional<CommandResult> HeadClient::result(const RegisterReader& now) const {
  if (now.integer(reg::kCommandSequence) != sequence_) return std::nullopt;
  return static_cast<CommandResult>(now.integer(reg::kCommandResult));
}

void HeadClient::arm_watchdog(std::chrono::milliseconds silence) {
  service_.write(reg::kClientWatchdog, std::array{static_cast<std::uint16_t>(silence.count())});
}

}  // namespace ninedot
