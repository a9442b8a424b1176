#include "programs/service/service_watch.h"

#include <fmt/format.h>

#include <csignal>
#include <cstring>

#include "drivers/posix/board_temperature.h"
#include "drivers/posix/service_manager.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// What a client's command waits for at most.
constexpr auto kPeriod = 20ms;

}  // namespace

void watch_until_signalled(const TerminationSignals& signals, const RunningService& service,
                           const std::function<void()>& reload) {
  ServiceManager manager;
  MonoTime measured_at{};
  std::uint64_t seen = 0;
  for (;;) {
    const int signal = signals.wait(kPeriod);
    if (signal != 0 && (signal != SIGHUP || signals.has_lost_terminal())) break;
    if (signal == SIGHUP) reload();
    const MonoTime now = mono_now();
    const auto [report, version] = service.reports.read_with_version();
    for (const std::unique_ptr<Output>& output : service.outputs) output->take(report, version != seen, now);
    seen = version;
    // Without its camera the service is up as well: it answers, says so, and recovers by itself.
    if (service.frames.frames_processed() > 0 || report.reason == Reason::kCameraLost) manager.ready();
    // A source that is over ends on purpose: from then on time itself counts as progress.
    manager.feed_watchdog(service.frames.over() ? static_cast<std::uint64_t>(to_ns(now)) : service.frames.turns(), now);
    if (now - measured_at >= 1s) {
      measured_at = now;
      service.frames.set_temperature(read_board_temperature());
    }
  }
  manager.stopping();
}

std::string realtime_text(int priority, const Result<void>& entered) {
  if (entered) return fmt::format("SCHED_FIFO {}", priority);
  if (priority == 0) return "ordinary priority, as configured";
  return fmt::format("ordinary priority: SCHED_FIFO {} was refused ({}): allow it with LimitRTPRIO= or `ulimit -r`",
                     priority, std::strerror(entered.error().os_errno));
}

std::string memory_text(bool wanted, const Result<void>& locked) {
  if (!wanted) return "not locked, as configured";
  if (locked) return "locked";
  return fmt::format("not locked ({}): allow it with LimitMEMLOCK= or `ulimit -l`",
                     std::strerror(locked.error().os_errno));
}

}  // namespace ninedot
