#pragma once
/// What the main thread does while the service runs: its list of outputs, the service manager, and signals, until one
/// asks to end.
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "base/mailbox.h"
#include "drivers/posix/signals.h"
#include "outputs/output.h"
#include "pipeline/frame_loop.h"

namespace ninedot {

struct RunningService {
  FrameLoop& frames;
  const Mailbox<Report>& reports;
  std::span<const std::unique_ptr<Output>> outputs;  ///< given the newest report every 20 ms, in this order
};

/// \param reload  called at each SIGHUP, unless it tells that the service's terminal is gone
/// \return  when SIGINT or SIGTERM came, or that SIGHUP.
void watch_until_signalled(const TerminationSignals& signals, const RunningService& service,
                           const std::function<void()>& reload);

/// "SCHED_FIFO 50", or why not and what to do about it.
std::string realtime_text(int priority, const Result<void>& entered);
/// "locked", or why not and what to do about it.
std::string memory_text(bool wanted, const Result<void>& locked);

}  // namespace ninedot
