#pragma once
/// What the main thread does while the service runs: log, service manager, display; until a signal asks to end.
#include "base/mailbox.h"
#include "drivers/modbus/server.h"
#include "drivers/posix/signals.h"
#include "pipeline/frame_loop.h"
#include "programs/service/service_log.h"

namespace ninedot {

struct RunningService {
  FrameLoop& frames;
  const Mailbox<Report>& reports;
  const Mailbox<Health>& health;
  ModbusServer& modbus;
  RegisterCodecOptions codec;
  HeadControl* head;          ///< may be null
  DigitalOutput* status_led;  ///< may be null
};

/// \param display  may be null. \return when SIGINT or SIGTERM came.
void watch_until_signalled(const TerminationSignals& signals, const RunningService& service, ServiceLog& log,
                           LiveDisplay* display);

/// "SCHED_FIFO 50", or why not and what to do about it.
std::string realtime_text(int priority, int refused_errno);
/// "locked", or why not and what to do about it.
std::string memory_text(bool wanted, int refused_errno);

}  // namespace ninedot
