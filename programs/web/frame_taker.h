#pragma once
/// The recordings' end of the tap: every frame of whatever service runs behind it, into a queue.
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "base/mono_time.h"
#include "drivers/tap/tap_reader.h"
#include "programs/web/frame_queue.h"

namespace ninedot {

/// Memory: one frame, and the queue's. Threads: one.
class FrameTaker {
 public:
  FrameTaker(std::string tap_path, FrameQueue& queue) : path_(std::move(tap_path)), queue_(queue) {}

  /// The newest frame, if there is a new one; the tap is opened again where the service is another one.
  /// \return  how long to wait before the next look
  std::chrono::nanoseconds look(MonoTime now);
  /// Nothing is wanted: the tap is closed, memory is given back. \return  likewise
  std::chrono::nanoseconds rest();
  /// Why no frame comes; empty: not known.
  const std::string& trouble() const noexcept { return trouble_; }

 private:
  void open(MonoTime now);

  const std::string path_;
  FrameQueue& queue_;
  std::optional<TapReader> tap_;
  std::shared_ptr<const TapHeader> header_;
  QueuedFrame frame_;
  MonoTime looked_at_{};
  std::string trouble_;
};

}  // namespace ninedot
