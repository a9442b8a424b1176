#pragma once
/// Which order to the head belongs to which client's command, and what became of it.
#include <cstdint>
#include <optional>

#include "aim/aimer.h"
#include "drivers/modbus/command.h"
#include "report/report.h"

namespace ninedot {

struct EndedCommand {
  std::uint16_t sequence = 0;  ///< ClientCommand::sequence
  bool succeeded = false;
};

/// Memory: inside. Threads: one.
class CommandDesk {
 public:
  /// The order that carries a command out; from now on it is the one that is waited for, unless it is a watchdog's.
  AimOrder accept(const ClientCommand& command) noexcept;

  /// A client's watchdog takes the head away from the command that is under way: that one has failed. To be asked
  /// before accept(); nothing where none is under way, or where another client's command takes its place.
  std::optional<EndedCommand> end_for_watchdog(const ClientCommand& command) noexcept;

  /// Once for each command: when the report says that its order is done or has failed.
  std::optional<EndedCommand> end_by(const ReportHead& head) noexcept;

 private:
  std::uint32_t number_ = 0;                // of the newest order
  std::optional<std::uint16_t> under_way_;  // sequence of the command that it carries out
};

}  // namespace ninedot
