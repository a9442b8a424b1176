#pragma once
/// Real-time behaviour asked of Linux: scheduling class, locked memory, stacks without missing pages.
#include "base/result.h"
#include "ports/frame_thread.h"

namespace ninedot {

/// Runs a thread under SCHED_FIFO: the frame loop's, and those that wait for it.
class RealtimeThread final : public FrameThread {
 public:
  /// \param priority  1..99, or 0: ordinary scheduling, no complaint from the kernel expected.
  /// \param name  of the thread, at most 15 characters; must outlive this. Threads: any.
  explicit RealtimeThread(int priority, const char* name = "frames") noexcept : priority_(priority), name_(name) {}

  /// Threads: the one that is to become a real-time one, once, before its work begins.
  /// \error  kIo with errno: EPERM where neither CAP_SYS_NICE nor RLIMIT_RTPRIO allows it; ECANCELED for priority 0.
  Result<void> enter() noexcept override;

 private:
  int priority_;
  const char* name_;
};

/// Keeps all pages of this process in memory. Pages to come are included where that cannot make a later allocation
/// fail: as root, or where RLIMIT_MEMLOCK is unlimited.
/// \error  kIo with the errno that says why not (ENOMEM, EPERM: raise RLIMIT_MEMLOCK).
/// Threads: any, before the frame loop starts; waits until the pages are there.
Result<void> lock_memory() noexcept;

/// Gives threads started from now on a stack of a size that is worth locking (the default of 8 MiB is not).
/// \error  kIo with errno: threads have the stacks that they had before.
/// Threads: main, before it starts any other.
Result<void> use_small_thread_stacks() noexcept;

}  // namespace ninedot
