#pragma once
/// What systemd is told (sd_notify); does nothing where no service manager listens.
#include <chrono>
#include <cstdint>
#include <string>

#include "base/mono_time.h"

namespace ninedot {

/// Threads: one caller, an ordinary one: every report is a send(2) on a socket, which may wait for the service manager.
class ServiceManager {
 public:
  ServiceManager() noexcept;

  /// "Started": once, after the first frame came through.
  void ready() noexcept;
  /// One line for `systemctl status`.
  void status(const std::string& line) noexcept;
  void stopping() noexcept;

  /// Feeds the watchdog, if one is set (WatchdogSec=) and `progress` has grown since the last feeding. Call it several
  /// times per watchdog interval; feeds at most four times per interval.
  /// \return  whether it was fed
  bool feed_watchdog(std::uint64_t progress, MonoTime now) noexcept;

 private:
  std::chrono::nanoseconds watchdog_{};  // 0: none set
  MonoTime fed_at_{};
  std::uint64_t fed_progress_ = 0;
  bool is_ready_ = false;
};

}  // namespace ninedot
