#pragma once
/// Restarts the service, and watches whether it comes up and stays up.
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/mono_time.h"
#include "drivers/modbus/client.h"
#include "drivers/posix/signals.h"

namespace ninedot {

struct TrialOptions {
  std::vector<std::string> restart;  ///< program and arguments; empty: systemd's ninedotd.service
  std::chrono::seconds within{30};   ///< from the restart until it has been up for ServiceTrial::kStays
};

/// What a program did. \see run_program_for
struct ProgramOutcome {
  bool is_success = false;
  std::string what;       ///< "exit status 1", "still running after 30 s"
  std::string last_line;  ///< of what it printed
  std::string printed;    ///< the end of it, 4 kB
};

/// Tells how far it has come: a word and the rest of the line.
using TrialTeller = std::function<void(std::string_view phase, std::string_view words)>;

/// Threads: one, which made `signals`.
class ServiceTrial {
 public:
  /// So long it must have been up without a gap: a camera or a port that fails does so at the start.
  static constexpr std::chrono::seconds kStays{3};

  /// \param signals  one that comes ends a trial \param tell  both must outlive this
  ServiceTrial(TrialOptions options, const TerminationSignals& signals, const TrialTeller& tell)
      : options_(std::move(options)), signals_(signals), tell_(tell) {}

  /// \param host, port  of its Modbus TCP; empty: it serves none
  /// \return  why it does not run, in half a sentence; nothing: it does
  std::optional<std::string> restart_and_watch(const std::string& host, std::uint16_t port);
  /// A signal came: whoever waits has waited enough.
  bool is_interrupted() const noexcept { return is_interrupted_; }

 private:
  ProgramOutcome run_program_for(const std::vector<std::string>& words, MonoTime until);
  std::optional<std::string> why_not_up(const std::string& host, std::uint16_t port);
  std::optional<std::string> why_no_answer(const std::string& host, std::uint16_t port);
  std::optional<std::string> why_not_active();
  bool waits(std::chrono::nanoseconds time);

  const TrialOptions options_;
  const TerminationSignals& signals_;
  const TrialTeller& tell_;
  std::optional<ModbusTcpClient> client_;
  std::string process_;  // systemd's word on it
  MonoTime restarted_at_{};
  bool is_new_process_ = false;
  bool is_interrupted_ = false;
};

}  // namespace ninedot
