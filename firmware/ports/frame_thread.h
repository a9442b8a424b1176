#pragma once
/// What the frame loop asks of the operating system when its thread begins. Implemented in drivers/posix.

namespace ninedot {

class FrameThread {
 public:
  virtual ~FrameThread() = default;
  /// Makes the calling thread a real-time one and touches its stack, so that no page of it is missing later.
  /// \return  0, or the errno that says why the thread runs without real-time priority.
  virtual int enter() noexcept = 0;
};

}  // namespace ninedot
