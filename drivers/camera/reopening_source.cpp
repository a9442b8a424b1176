// The device belongs to the caller of `next` while the state is kRunning and to the supervisor while it is kLost; the
// state changes hands under the mutex, which nobody holds across a call of the device.
#include "drivers/camera/reopening_source.h"

#include <pthread.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

namespace ninedot {

ReopeningSource::ReopeningSource(std::unique_ptr<CameraDevice> device, const ReopenOptions& options)
    : device_(std::move(device)), options_(options), pause_(options.first_pause) {
  if (options_.wait_for_device) {
    try_open();
  } else {
    device_->open();
    note_opened();
  }
  // Signals are for the main thread, which waits for them.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  supervisor_ = std::thread([this] { supervise(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(supervisor_.native_handle(), "camera");
}

ReopeningSource::~ReopeningSource() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  supervisor_.join();
  device_->close();
}

Result<FrameLease> ReopeningSource::next(MonoTime deadline) noexcept {
  {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_until(lock, deadline, [this] { return state_ == State::kRunning; }))
      return tl::unexpected<Error>(lost_);
  }
  const Result<GrabbedFrame> frame = device_->grab(std::min(deadline, expected_by_));
  if (frame) return lend(*frame);
  switch (frame.error().code) {
    case Errc::kNoFrame:
      if (mono_now() < expected_by_) return tl::unexpected<Error>(frame.error());
      return lose(Error{Errc::kCameraLost, 0, "the camera delivers no frames"});
    case Errc::kFrameUnreadable:
      expected_by_ = mono_now() + stall_after_;
      return tl::unexpected<Error>(frame.error());
    default:
      return lose(Error{Errc::kCameraLost, frame.error().os_errno, frame.error().text});
  }
}

FrameLease ReopeningSource::lend(const GrabbedFrame& grabbed) noexcept {
  expected_by_ = mono_now() + stall_after_;
  // Drivers that don't count say 0 for ever; a count that goes back was started anew.
  const std::uint32_t step = grabbed.sequence - last_sequence_;
  const bool is_gap = has_delivered_ && step > 1 && step < 0x80000000U;
  const std::uint32_t passed = std::max(is_gap ? step - 1 : 0U, grabbed.skipped + grabbed.flagged);
  last_sequence_ = grabbed.sequence;
  has_delivered_ = true;
  flagged_.fetch_add(grabbed.flagged, std::memory_order_relaxed);
  if (has_number_) frame_number_ += std::uint64_t{passed} + 1;
  has_number_ = true;
  {
    const std::lock_guard lock(mutex_);
    ++lent_;
  }
  FrameLease lease(this, grabbed.buffer);
  lease.frame = grabbed.frame;
  lease.frame.number = frame_number_;
  lease.dropped_before = passed - grabbed.flagged;
  return lease;
}

void ReopeningSource::give_back(std::uint32_t buffer) noexcept {
  device_->release(buffer);
  const std::lock_guard lock(mutex_);
  if (--lent_ == 0 && state_ == State::kLost) changed_.notify_all();
}

tl::unexpected<Error> ReopeningSource::lose(const Error& error) noexcept {
  {
    const std::lock_guard lock(mutex_);
    state_ = State::kLost;
    lost_ = error;
    // A device that opens but never delivers is not asked ten times a second.
    pause_ = has_delivered_ ? options_.first_pause : std::min(2 * pause_, options_.longest_pause);
  }
  changed_.notify_all();
  return tl::unexpected<Error>(error);
}

void ReopeningSource::note_opened() noexcept {
  const std::string description = device_->description();
  const std::lock_guard lock(mutex_);
  if (was_open_) restarts_.fetch_add(1, std::memory_order_relaxed);
  was_open_ = true;
  has_delivered_ = false;
  stall_after_ = options_.stall_periods * device_->frame_period();
  expected_by_ = mono_now() + std::max(stall_after_, options_.first_frame_within);
  description_ = description;
  state_ = State::kRunning;
}

bool ReopeningSource::try_open() noexcept {
  try {
    device_->open();
    note_opened();
    return true;
  } catch (const CameraRefused& refused) {
    const std::lock_guard lock(mutex_);
    // The system's own words for it are "Link has been severed".
    lost_ =
        refused.os_errno == ENOLINK
            ? Error{Errc::kCameraLost, 0, "no usable signal at the camera's input: check cable, power and video mode"}
            : Error{Errc::kCameraLost, refused.os_errno, "the camera can't be opened"};
    description_ = refused.what();
  } catch (const std::exception& failure) {
    const std::lock_guard lock(mutex_);
    lost_ = Error{Errc::kCameraLost, 0, "the camera can't be opened"};
    description_ = failure.what();
  }
  return false;
}

void ReopeningSource::supervise() noexcept {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || (state_ == State::kLost && lent_ == 0); });
    if (stop_) return;
    lock.unlock();
    device_->close();
    lock.lock();
    if (changed_.wait_until(lock, mono_now() + pause_, [this] { return stop_; })) return;
    lock.unlock();
    const bool is_open = try_open();
    lock.lock();
    if (is_open)
      changed_.notify_all();
    else
      pause_ = std::min(2 * pause_, options_.longest_pause);
  }
}

SourceCounters ReopeningSource::counters() const noexcept {
  return {restarts_.load(std::memory_order_relaxed), flagged_.load(std::memory_order_relaxed)};
}

std::string ReopeningSource::description() const {
  const std::lock_guard lock(mutex_);
  return description_;
}

}  // namespace ninedot
