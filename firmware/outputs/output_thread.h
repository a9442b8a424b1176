#pragma once
/// A thread that gives one output each new report, and calls it at least once per period.
#include <chrono>
#include <thread>

#include "base/mailbox.h"
#include "base/result.h"
#include "outputs/output.h"
#include "ports/frame_thread.h"

namespace ninedot {

/// Reports that come while the output is busy are skipped: the newest wins. Memory: none after construction.
class OutputThread {
 public:
  /// Returns when the thread has asked `thread` for its priority. All three must outlive this.
  /// \param period  the longest time between two calls, and the longest that the destructor takes beside the output
  OutputThread(const Mailbox<Report>& reports, Output& output, FrameThread& thread, std::chrono::nanoseconds period);
  ~OutputThread() = default;
  OutputThread(const OutputThread&) = delete;
  OutputThread& operator=(const OutputThread&) = delete;

  /// \error  kIo with the errno with which real-time priority was refused. Threads: any.
  const Result<void>& realtime() const noexcept { return realtime_; }

 private:
  Result<void> realtime_;  // written before the constructor ends
  std::jthread thread_;
};

}  // namespace ninedot
