#pragma once
/// The head of a running service as a Modbus client commands it, with errors that say what to do.
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "programs/commands/service_client.h"
#include "proto/register_map.h"

namespace ninedot {

/// Each call throws StartupError(kWorkFailed) where the service does not answer or refuses. Threads: one.
class HeadClient {
 public:
  /// Throws StartupError(kWorkFailed) likewise, and where the service has no head or takes no commands.
  HeadClient(const std::string& host, std::uint16_t port);

  /// As ServiceClient::read.
  RegisterReader read() { return service_.read(); }
  /// \param pan_deg, tilt_deg  nothing: as it stands
  void point(std::optional<double> pan_deg, std::optional<double> tilt_deg);
  void follow() { command(Command::kFollow); }
  void park() { command(Command::kPark); }
  /// What became of the newest of these commands; nothing: another client's has taken its place.
  std::optional<CommandResult> result(const RegisterReader& now) const;
  /// For as long as this is connected: should it fall silent for so long, or end, the head follows again. 0: off.
  void arm_watchdog(std::chrono::milliseconds silence);

  /// As ServiceClient::fail.
  [[noreturn]] void fail(const std::string& what) const { service_.fail(what); }

 private:
  void command(Command command);

  ServiceClient service_;
  std::uint16_t sequence_ = 0;  // of the newest command that this knows of
};

}  // namespace ninedot
