// The device belongs to the caller of `next` while the state is kRunning and to the supervisor while it is kLost;
// whoever has it stores the other state to hand it over. Only the supervisor closes it, so it may tend it while it
// runs.
#include "drivers/camera/reopening_source.h"

#include <pthread.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>

namespace ninedot {

ReopeningSource::ReopeningSource(std::unique_ptr<CameraDevice> device, const ReopenOptions& options)
    : device_(std::move(device)), options_(options), backoff_(options.first_pause, options.longest_pause) {
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
  stop_.ring();
  supervisor_.join();
  device_->close();
}

Result<FrameLease> ReopeningSource::next(MonoTime deadline) noexcept {
  while (state_.load() != State::kRunning)
    if (!opened_.wait_until(deadline) && state_.load() != State::kRunning) return why_lost();
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
  lent_.fetch_add(1);
  FrameLease lease(this, grabbed.buffer);
  lease.frame = grabbed.frame;
  lease.frame.number = frame_number_;
  lease.dropped_before = passed - grabbed.flagged;
  return lease;
}

void ReopeningSource::give_back(std::uint32_t buffer) noexcept {
  device_->release(buffer);
  // In one order for all (seq_cst): either this sees that the camera is lost, or the supervisor sees no lease.
  if (lent_.fetch_sub(1) == 1 && state_.load() == State::kLost) changed_.ring();
}

tl::unexpected<Error> ReopeningSource::lose(const Error& error) noexcept {
  lost_ = error;
  refused_errno_.store(kNotTried);
  state_.store(State::kLost);
  changed_.ring();
  return tl::unexpected<Error>(error);
}

tl::unexpected<Error> ReopeningSource::why_lost() const noexcept {
  switch (const int os_errno = refused_errno_.load()) {
    case kNotTried:
      return tl::unexpected<Error>(lost_);
    case ENOLINK:  // the system's own words for it are "Link has been severed"
      return fail(Errc::kCameraLost, "no usable signal at the camera's input: check cable, power and video mode");
    default:
      return fail(Errc::kCameraLost, "the camera can't be opened", os_errno);
  }
}

void ReopeningSource::note_opened() {
  {
    std::string description = device_->description();
    const std::lock_guard lock(texts_mutex_);
    description_ = std::move(description);
    refusal_.clear();
  }
  if (was_open_) restarts_.fetch_add(1, std::memory_order_relaxed);
  was_open_ = true;
  has_delivered_ = false;
  stall_after_ = options_.stall_periods * device_->frame_period();
  expected_by_ = mono_now() + std::max(stall_after_, options_.first_frame_within);
  state_.store(State::kRunning);
  opened_.ring();
}

bool ReopeningSource::try_open() noexcept {
  try {
    device_->open();
    note_opened();
    return true;
  } catch (const CameraRefused& refused) {
    note_refusal(refused.os_errno, refused.what());
  } catch (const std::exception& failure) {
    note_refusal(0, failure.what());
  }
  return false;
}

void ReopeningSource::note_refusal(int os_errno, const char* line) noexcept {
  refused_errno_.store(os_errno);
  const std::lock_guard lock(texts_mutex_);
  description_ = refusal_ = line;
}

void ReopeningSource::supervise() noexcept {
  while (tend_until_lost()) {
    device_->close();
    // A device that opens but never delivers is not asked ten times a second.
    if (has_delivered_) backoff_.reset();
    do {
      if (is_rung_within(stop_, backoff_.next())) return;
    } while (!try_open());
  }
}

/// \return  true: the camera is lost and all its buffers are back; false: the source is being destroyed
bool ReopeningSource::tend_until_lost() noexcept {
  MonoTime ask_at = mono_now();
  for (;;) {
    const bool is_lost = state_.load() == State::kLost;
    if (is_lost && lent_.load() == 0) return true;
    if (!is_lost && mono_now() >= ask_at) {
      const auto pause = device_->refresh();
      ask_at = pause ? mono_now() + *pause : MonoTime::max();
    }
    std::array<pollfd, 2> polled{{{stop_.get(), POLLIN, 0}, {changed_.get(), POLLIN, 0}}};
    poll_until(polled, is_lost ? MonoTime::max() : ask_at);
    if (polled[0].revents != 0) return false;
    if (polled[1].revents != 0) changed_.answer();
  }
}

SourceCounters ReopeningSource::counters() const noexcept {
  return {restarts_.load(std::memory_order_relaxed), flagged_.load(std::memory_order_relaxed)};
}

std::string ReopeningSource::description() const {
  const std::lock_guard lock(texts_mutex_);
  return description_;
}

std::string ReopeningSource::last_refusal() const {
  const std::lock_guard lock(texts_mutex_);
  return refusal_;
}

}  // namespace ninedot
