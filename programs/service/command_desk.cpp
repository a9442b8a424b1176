#include "programs/service/command_desk.h"

#include <utility>

namespace ninedot {

AimOrder CommandDesk::accept(const ClientCommand& command) noexcept {
  if (++number_ == 0) number_ = 1;  // 0: no order
  under_way_ = command.from_watchdog ? std::nullopt : std::optional(command.sequence);
  return {command.command == Command::kFollow,
          {command.pan_rad, command.tilt_rad},
          number_,
          command.command == Command::kPark};
}

std::optional<EndedCommand> CommandDesk::end_for_watchdog(const ClientCommand& command) noexcept {
  if (!command.from_watchdog || !under_way_) return std::nullopt;
  return EndedCommand{*std::exchange(under_way_, std::nullopt), false};
}

std::optional<EndedCommand> CommandDesk::end_by(const ReportHead& head) noexcept {
  if (!under_way_ || head.order != number_) return std::nullopt;
  if (head.progress != OrderProgress::kDone && head.progress != OrderProgress::kFailed) return std::nullopt;
  return EndedCommand{*std::exchange(under_way_, std::nullopt), head.progress == OrderProgress::kDone};
}

}  // namespace ninedot
