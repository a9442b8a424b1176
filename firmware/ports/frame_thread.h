#pragma once
/// What the frame loop asks of the operating system when its thread begins. Implemented in drivers/posix.
#include "base/result.h"

namespace ninedot {

/// Threads: one object for one thread; nothing is shared.
class FrameThread {
 public:
  virtual ~FrameThread() = default;
  /// Makes the calling thread a real-time one and touches its stack, so that no page of it is missing later.
  /// Threads: the frame loop's own, once, before its first frame; not real-time safe itself (it brings pages in).
  /// \error  kIo with the errno that says why the thread runs without real-time priority.
  virtual Result<void> enter() noexcept = 0;
};

}  // namespace ninedot
