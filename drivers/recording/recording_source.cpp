// One thread decodes. With kEveryFrame and kAsTaken it puts the frames into a queue, in order, and waits for a free
// buffer. With kRealTime it works ahead, sleeps until the frame's turn and replaces what nobody took. Buffers go round
// through atomics, and both sides sleep on bells: nobody holds a lock.
#include "drivers/recording/recording_source.h"

#include <pthread.h>

#include <algorithm>
#include <bit>
#include <csignal>
#include <cstdio>
#include <utility>

namespace ninedot {

RecordingSource::RecordingSource(const std::string& path, const RecordingOptions& options)
    : options_(options),
      index_(read_recording_index(path)),
      size_(options.size == PictureSize{} ? index_.size : options.size),
      reader_(index_, size_) {
  set_times();
  if (!preload())
    for (Buffer& buffer : buffers_)
      buffer.own.bytes = std::make_unique_for_overwrite<std::uint8_t[]>(3 * size_.pixel_count());
  if (needs_no_thread()) return;
  // Signals are for the main thread, which waits for them.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  decoder_ = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(decoder_.native_handle(), "recording");
}

RecordingSource::~RecordingSource() {
  if (!decoder_.joinable()) return;
  stop_.store(true);
  changed_.ring();
  decoder_.join();
}

Result<FrameLease> RecordingSource::next(MonoTime deadline) noexcept {
  if (needs_no_thread()) return lend_preloaded();
  if (!started_at()) {
    started_at_ns_.store(to_ns(mono_now()), std::memory_order_release);
    changed_.ring();
  }
  for (bool is_in_time = true;; is_in_time = ready_.wait_until(deadline)) {
    // Before the look for a frame: what came before the end is there then.
    const bool is_over = finished_.load(std::memory_order_acquire);
    if (const auto taken = take_ready()) return lend(*taken);
    if (is_over) return fail(Errc::kEndOfStream, "the recording is over");
    if (!is_in_time) return fail(Errc::kNoFrame, "no frame in time");
  }
}

std::optional<NewestWins::Taken> RecordingSource::take_ready() noexcept {
  if (is_real_time()) return newest_.take();
  if (queued_.load(std::memory_order_acquire) == unqueued_) return std::nullopt;
  return NewestWins::Taken{queue_[unqueued_++ % kBufferCount], {}};
}

Result<FrameLease> RecordingSource::lend_preloaded() noexcept {
  const std::size_t i = lent_ % preloaded_.size();
  label(buffers_[0], i, lent_ / preloaded_.size());
  buffers_[0].picture = &preloaded_[i];
  ++lent_;
  return lend({0, {}});
}

Result<FrameLease> RecordingSource::lend(const NewestWins::Taken& taken) noexcept {
  const Buffer& ready = buffers_[taken.buffer];
  const Picture& picture = *ready.picture;
  if (!picture.chroma) {
    std::snprintf(last_failure_.data(), last_failure_.size(), "%s: frame %llu: %s",
                  ready.frame->file.empty() ? index_.path.c_str() : ready.frame->file.c_str(),
                  static_cast<unsigned long long>(ready.frame->number), picture.chroma.error().text);
    const Error error = picture.chroma.error();
    give_back(taken.buffer);
    return tl::unexpected<Error>(error);
  }
  const bool is_preloaded = !preloaded_.empty();
  FrameLease lease(is_preloaded ? nullptr : this, taken.buffer);
  lease.frame.luma = ImageView{picture.bytes.get(), size_.width_px, size_.height_px, size_.width_px};
  lease.frame.chroma = *picture.chroma;
  lease.frame.number = ready.number;
  const MonoTime exposed_at = options_.pace == RecordingPace::kAsTaken ? mono_now() : ready.exposed_at;
  lease.frame.set_exposure(exposed_at);
  lease.frame.head = HeadAngles{ready.frame->pan_rad, ready.frame->tilt_rad};
  lease.frame.head_at = exposed_at;
  if (ready.frame->zoom) lease.frame.zoom = *ready.frame->zoom;
  lease.dropped_before = taken.unseen.skipped;
  if (is_preloaded) give_back(taken.buffer);
  return lease;
}

void RecordingSource::give_back(std::uint32_t buffer) noexcept {
  free_.fetch_or(1U << buffer, std::memory_order_release);
  changed_.ring();
}

std::optional<MonoTime> RecordingSource::started_at() const noexcept {
  const std::int64_t ns = started_at_ns_.load(std::memory_order_acquire);
  if (ns == kNotStarted_ns) return std::nullopt;
  return MonoTime(std::chrono::nanoseconds(ns));
}

void RecordingSource::set_times() {
  for (std::size_t i = 0; i < index_.frames.size(); ++i)
    times_.push_back(options_.rate_hz > 0 ? std::chrono::nanoseconds(static_cast<std::int64_t>(static_cast<double>(i) *
                                                                                               1e9 / options_.rate_hz))
                                          : index_.frames[i].recorded_at);
  const std::chrono::nanoseconds whole = times_.back() - times_.front();
  const double rate_hz = options_.rate_hz > 0 ? options_.rate_hz : kUntimedRate_hz;
  // From the last frame to the first of the next pass: the mean distance of two frames.
  const std::chrono::nanoseconds step = times_.size() > 1
                                            ? whole / static_cast<std::int64_t>(times_.size() - 1)
                                            : std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / rate_hz));
  pass_duration_ = whole + step;
}

std::chrono::nanoseconds RecordingSource::time_of(std::size_t i, std::uint64_t pass) const noexcept {
  return times_[i] + static_cast<std::int64_t>(pass) * pass_duration_;
}

Result<ChromaView> RecordingSource::decode(std::size_t i, std::uint8_t* bytes) noexcept {
  const std::size_t luma_bytes = size_.pixel_count();
  return reader_.read(index_.frames[i], std::span(bytes, luma_bytes), std::span(bytes + luma_bytes, 2 * luma_bytes));
}

/// \return  false: not asked for, or the pictures do not fit; then nothing is kept
bool RecordingSource::preload() {
  const std::size_t luma_bytes = size_.pixel_count();
  if (!options_.loop || luma_bytes * index_.frames.size() > options_.preload_bytes) return false;
  std::size_t whole_bytes = 0;
  auto whole = std::make_unique_for_overwrite<std::uint8_t[]>(3 * luma_bytes);
  for (std::size_t i = 0; i < index_.frames.size(); ++i) {
    Picture picture{nullptr, decode(i, whole.get())};
    const bool is_grey = !picture.chroma || picture.chroma->empty();
    whole_bytes += is_grey ? luma_bytes : 3 * luma_bytes;
    if (whole_bytes > options_.preload_bytes) {
      preloaded_.clear();
      return false;
    }
    if (is_grey) {
      picture.bytes = std::make_unique_for_overwrite<std::uint8_t[]>(luma_bytes);
      std::copy_n(whole.get(), luma_bytes, picture.bytes.get());
    } else {
      picture.bytes = std::exchange(whole, std::make_unique_for_overwrite<std::uint8_t[]>(3 * luma_bytes));
    }
    preloaded_.push_back(std::move(picture));
  }
  return true;
}

void RecordingSource::run() noexcept {
  std::uint64_t pass = 0;
  do {
    for (std::size_t i = 0; i < index_.frames.size(); ++i)
      if (!produce(i, pass)) return;
    ++pass;
  } while (options_.loop);
  finished_.store(true, std::memory_order_release);
  ready_.ring();
}

/// Sleeps until then, or until `is_enough`. \return  false: being destroyed
template <typename Condition>
bool RecordingSource::wait_until(MonoTime until, Condition is_enough) noexcept {
  for (;;) {
    if (stop_.load()) return false;
    if (is_enough() || mono_now() >= until) return true;
    changed_.wait_until(until);
  }
}

/// Sleeps until the frame's turn or until `is_enough`; before the first call of `next` there is no turn.
/// \return  false: being destroyed
template <typename Condition>
bool RecordingSource::wait_for_turn(std::chrono::nanoseconds since_start, Condition is_enough) noexcept {
  if (!wait_until(MonoTime::max(), [this] { return started_at().has_value(); })) return false;
  return wait_until(*started_at() + since_start, is_enough);
}

/// One frame, from its file to where `next` finds it. \return  false: the source is being destroyed
bool RecordingSource::produce(std::size_t i, std::uint64_t pass) noexcept {
  const std::chrono::nanoseconds since_start = time_of(i, pass) - times_.front();
  const auto has_room = [this] { return has_free(); };
  if (!is_real_time()) {
    if (!wait_until(MonoTime::max(), has_room)) return false;
  } else if (!has_free() && !wait_for_turn(since_start, has_room)) {
    return false;
  }
  if (stop_.load()) return false;
  const std::chrono::nanoseconds until_next =
      (i + 1 < times_.size() ? time_of(i + 1, pass) : time_of(0, pass + 1)) - times_.front();
  const bool is_late = is_real_time() && started_at() && mono_now() > *started_at() + until_next;
  const std::uint32_t place = is_late ? NewestWins::kNone : take_free();
  if (place == NewestWins::kNone) {  // late, or the caller holds every buffer: lost, as it would be in a camera
    ++dropped_;
    return true;
  }
  Buffer& buffer = buffers_[place];
  label(buffer, i, pass);
  if (preloaded_.empty()) buffer.own.chroma = decode(i, buffer.own.bytes.get());
  buffer.picture = preloaded_.empty() ? &buffer.own : &preloaded_[i];
  if (is_real_time()) {
    if (!wait_for_turn(since_start, [] { return false; })) return false;
    buffer.exposed_at = *started_at() + since_start;
  }
  put_ready(place);
  return true;
}

/// Which frame it is, and when it was recorded.
void RecordingSource::label(Buffer& buffer, std::size_t i, std::uint64_t pass) const noexcept {
  buffer.frame = &index_.frames[i];
  buffer.number = buffer.frame->number + pass * (index_.frames.back().number + 1);
  buffer.exposed_at = MonoTime(time_of(i, pass));
}

/// A buffer to decode into, if need be that of a frame that nobody took in time. kNone: the caller holds them all.
std::uint32_t RecordingSource::take_free() noexcept {
  if (const std::uint32_t free = free_.load(std::memory_order_acquire); free != 0) {
    const auto buffer = static_cast<std::uint32_t>(std::countr_zero(free));
    free_.fetch_and(~(1U << buffer), std::memory_order_acq_rel);
    return buffer;
  }
  const auto unseen = newest_.reclaim();
  if (!unseen) return NewestWins::kNone;
  dropped_ += unseen->unseen.skipped + 1;
  return unseen->buffer;
}

void RecordingSource::put_ready(std::uint32_t buffer) noexcept {
  if (is_real_time()) {
    const std::uint32_t older = newest_.put(buffer, {.skipped = std::exchange(dropped_, 0)});
    if (older != NewestWins::kNone) free_.fetch_or(1U << older, std::memory_order_release);
  } else {
    const std::uint32_t place = queued_.load(std::memory_order_relaxed);
    queue_[place % kBufferCount] = buffer;
    queued_.store(place + 1, std::memory_order_release);
  }
  ready_.ring();
}

}  // namespace ninedot
