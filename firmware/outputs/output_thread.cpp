#include "outputs/output_thread.h"

#include <cstdint>
#include <latch>

namespace ninedot {
namespace {

void run(const std::stop_token& stop, const Mailbox<Report>& reports, Output& output, std::chrono::nanoseconds period) {
  std::uint64_t seen = 0;
  while (!stop.stop_requested()) {
    reports.wait_newer(seen, mono_now() + period);
    const auto [report, version] = reports.read_with_version();
    output.take(report, version != seen, mono_now());
    seen = version;
  }
}

}  // namespace

OutputThread::OutputThread(const Mailbox<Report>& reports, Output& output, FrameThread& thread,
                           std::chrono::nanoseconds period) {
  std::latch entered(1);
  thread_ = std::jthread([&, period](const std::stop_token& stop) {
    const Mailbox<Report>& source = reports;
    Output& target = output;
    realtime_ = thread.enter();
    entered.count_down();
    run(stop, source, target, period);
  });
  entered.wait();
}

}  // namespace ninedot
