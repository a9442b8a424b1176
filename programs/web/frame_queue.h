#pragma once
/// Between who takes frames from the tap and who writes them: a disk that stands still for a moment loses none.
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "base/mono_time.h"
#include "drivers/tap/tap_reader.h"

namespace ninedot {

struct QueuedFrame {
  TapCopy copy;
  std::shared_ptr<const TapHeader> header;  ///< of the service that it is of: another one is another service
};

/// Frames are swapped in and out, so that the same buffers go round. A full queue takes none: what is lost shows as
/// a gap in the recording's numbers.
/// Memory: kMost_bytes, and no less than two frames; made by `reserve`, given back by `clear`.
/// Threads: one that gives, one that takes; `wake` any.
class FrameQueue {
 public:
  static constexpr std::size_t kMost_bytes = std::size_t{12} << 20U;  ///< half a second of 640 x 480, grey, at 35 Hz
  static constexpr std::size_t kMostFrames = 16;

  /// Empties it. \param frame_bytes  room that a frame's pixels may need
  void reserve(std::size_t frame_bytes);
  void clear();

  /// \return  false: it is full, and `frame` as it was
  bool push(QueuedFrame& frame);
  /// Waits until there is a frame, somebody called `wake`, or the time is over. \return  whether there was a frame
  bool pop(QueuedFrame& frame, MonoTime deadline);
  void wake();

 private:
  std::mutex mutex_;  // of all that follows
  std::condition_variable news_;
  std::vector<QueuedFrame> slots_;
  std::size_t first_ = 0, count_ = 0;
  bool is_woken_ = false;
};

}  // namespace ninedot
