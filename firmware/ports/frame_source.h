#pragma once
/// Where frames come from. Implemented in drivers/camera and drivers/recording.
#include <chrono>
#include <cstdint>
#include <utility>

#include "base/result.h"
#include "image/frame.h"

namespace ninedot {

/// Gives a frame's buffer back to its owner. One per source.
class FrameOwner {
 public:
  virtual void give_back(std::uint32_t buffer) noexcept = 0;

 protected:
  ~FrameOwner() = default;
};

/// One frame, lent: the destructor gives the buffer back. Move-only. Must not outlive its source.
class FrameLease {
 public:
  FrameLease() = default;
  FrameLease(FrameOwner* owner, std::uint32_t buffer) noexcept : owner_(owner), buffer_(buffer) {}
  FrameLease(FrameLease&& other) noexcept { *this = std::move(other); }
  FrameLease& operator=(FrameLease&& other) noexcept {
    if (this != &other) {
      release();
      owner_ = std::exchange(other.owner_, nullptr);
      buffer_ = other.buffer_;
      frame = other.frame;
      dropped_before = other.dropped_before;
    }
    return *this;
  }
  ~FrameLease() { release(); }

  Frame frame;                       ///< its pixels are valid while the lease lives
  std::uint32_t dropped_before = 0;  ///< frames lost since the one before: skipped by the source or by newest-wins

 private:
  void release() noexcept {
    if (owner_ != nullptr) std::exchange(owner_, nullptr)->give_back(buffer_);
  }
  FrameOwner* owner_ = nullptr;
  std::uint32_t buffer_ = 0;
};

/// What a source counts over its life, beside what FrameLease::dropped_before tells.
struct SourceCounters {
  std::uint32_t restarts = 0;  ///< how often a lost camera was opened again
  std::uint32_t flagged = 0;   ///< buffers that the device itself marked as damaged; never lent
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The newest frame not yet taken; older ones are given back and counted. Waits at most until `deadline`.
  /// \error kNoFrame: none came in time. kEndOfStream: a recording that does not loop is over.
  ///        kCameraLost, kFrameSize, kFrameUnreadable: this frame or device failed; asking again is allowed.
  /// Memory: none after construction. Threads: one caller.
  virtual Result<FrameLease> next(MonoTime deadline) noexcept = 0;
  /// Any thread.
  virtual SourceCounters counters() const noexcept { return {}; }
};

}  // namespace ninedot
