#pragma once
/// Where frames come from. Implemented in drivers/camera and drivers/recording.
#include <chrono>
#include <cstdint>
#include <utility>

#include "base/mono_time.h"
#include "base/result.h"
#include "image/chroma_view.h"
#include "image/image_view.h"

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
      luma = other.luma, chroma = other.chroma, frame_number = other.frame_number, exposed_at = other.exposed_at,
      dropped_before = other.dropped_before;
      pan_rad = other.pan_rad, tilt_rad = other.tilt_rad;
    }
    return *this;
  }
  ~FrameLease() { release(); }

  ImageView luma;                    ///< valid while the lease lives
  ChromaView chroma;                 ///< likewise; empty where the source gives no colour
  std::uint64_t frame_number = 0;    ///< the source's own count (a recording's frame number; a camera's sequence)
  MonoTime exposed_at{};             ///< middle of the exposure
  std::uint32_t dropped_before = 0;  ///< frames lost since the one before: skipped by the source or by newest-wins
  double pan_rad = 0, tilt_rad = 0;  ///< of the camera where the source knows them (recordings), else 0

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
