#include "programs/web/frame_queue.h"

#include <algorithm>
#include <utility>

namespace ninedot {

void FrameQueue::reserve(std::size_t frame_bytes) {
  const std::lock_guard lock(mutex_);
  const std::size_t fitting = kMost_bytes / std::max<std::size_t>(frame_bytes, 1);
  slots_ = std::vector<QueuedFrame>(std::clamp<std::size_t>(fitting, 2, kMostFrames));
  first_ = count_ = 0;
}

void FrameQueue::clear() {
  const std::lock_guard lock(mutex_);
  slots_ = {};
  first_ = count_ = 0;
}

bool FrameQueue::push(QueuedFrame& frame) {
  {
    const std::lock_guard lock(mutex_);
    if (count_ == slots_.size()) return false;
    std::swap(slots_[(first_ + count_++) % slots_.size()], frame);
  }
  news_.notify_one();
  return true;
}

bool FrameQueue::pop(QueuedFrame& frame, MonoTime deadline) {
  std::unique_lock lock(mutex_);
  news_.wait_until(lock, deadline, [&] { return count_ > 0 || is_woken_; });
  is_woken_ = false;
  if (count_ == 0) return false;
  std::swap(slots_[first_], frame);
  first_ = (first_ + 1) % slots_.size();
  --count_;
  return true;
}

void FrameQueue::wake() {
  {
    const std::lock_guard lock(mutex_);
    is_woken_ = true;
  }
  news_.notify_one();
}

}  // namespace ninedot
