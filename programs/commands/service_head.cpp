#include "programs/commands/service_head.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>

#include "base/aim_state.h"
#include "base/startup_error.h"
#include "base/units.h"
#include "programs/assembly/modbus_options.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// Between two requests of ours a picture is looked at; on a small board that takes some hundred milliseconds.
constexpr auto kSilence = 5s;

bool follows(const RegisterReader& now, const Config& config) {
  if (follows(static_cast<AimState>(now.integer(reg::kHeadState)))) return true;
  // It waits for a landmark, or has parked since there was none.
  const auto command = static_cast<Command>(now.integer(reg::kCommand));
  return command == Command::kFollow || (command == Command::kNone && config.pan_tilt.follow);
}

}  // namespace

ServiceHead::ServiceHead(const Config& config) : client_(address_from_here(config.modbus_tcp), config.modbus_tcp.port) {
  const RegisterReader now = client_.read();
  follows_ = follows(now, config);
  if (!follows_ && static_cast<Command>(now.integer(reg::kCommand)) != Command::kNone)
    client_.fail("a controller has sent the head where it is: `ninedot aim --follow` takes it back");
  if (follows_) client_.arm_watchdog(kSilence);
}

ServiceHead::~ServiceHead() {
  try {
    give_back();
  } catch (const StartupError& error) {
    fmt::print(stderr, "ninedot: the head could not be given back: {}\n", error.what());
  }
}

void ServiceHead::give_back() {
  // Of a head that is another's the watchdog would rob them.
  const bool is_ours = client_.result(client_.read()).has_value();
  if (is_ours && follows_) client_.follow();
  if (is_ours && !follows_) client_.point({}, {});
  if (follows_) client_.arm_watchdog(0ms);
}

void ServiceHead::go(const HeadAngles& goal) { client_.point(goal.pan_rad * kDegPerRad, goal.tilt_rad * kDegPerRad); }

TouredHead::State ServiceHead::state(const Frame& frame) {
  if (!frame.head) client_.fail("the service's frames come without the head's angles");
  const RegisterReader now = client_.read();
  const std::optional<CommandResult> result = client_.result(now);
  if (!result) client_.fail("another client has sent the head elsewhere meanwhile, and keeps it");
  State state{*frame.head, now.status(status_bit::kServoFault), now.status(status_bit::kInhibited)};
  switch (*result) {
    case CommandResult::kNone:
      break;
    case CommandResult::kRunning:
      state.progress = OrderProgress::kRunning;
      break;
    case CommandResult::kDone:
      state.progress = OrderProgress::kDone;
      break;
    case CommandResult::kFailed:
      state.progress = OrderProgress::kFailed;
      break;
  }
  return state;
}

}  // namespace ninedot
