// One thread decodes; `next` takes from a short queue. With kEveryFrame the queue holds decoded frames in order and the
// decoder waits for room. With kRealTime it holds one: the decoder works ahead, sleeps until the frame's turn and
// replaces what nobody took.
#include "drivers/recording/recording_source.h"

#include <pthread.h>

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
  const std::size_t whole_bytes = size_.pixel_count() * index_.frames.size();
  if (options_.loop && whole_bytes <= options_.preload_bytes) {
    preload();
  } else {
    store_ = std::make_unique<std::uint8_t[]>(size_.pixel_count() * kBufferCount);
    for (std::uint32_t buffer = 0; buffer < kBufferCount; ++buffer) free_[free_count_++] = buffer;
  }
  // Signals are for the main thread, which waits for them.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  decoder_ = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(decoder_.native_handle(), "recording");
}

RecordingSource::~RecordingSource() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  decoder_.join();
}

Result<FrameLease> RecordingSource::next(MonoTime deadline) noexcept {
  std::unique_lock lock(mutex_);
  if (!started_at_) {
    started_at_ = mono_now();
    changed_.notify_all();
  }
  if (!changed_.wait_until(lock, deadline, [this] { return ready_count_ > 0 || finished_; }))
    return fail(Errc::kNoFrame, "no frame in time");
  if (ready_count_ == 0) return fail(Errc::kEndOfStream, "the recording is over");
  const ReadyFrame ready = ready_[ready_begin_];
  ready_begin_ = (ready_begin_ + 1) % kBufferCount;
  --ready_count_;
  lock.unlock();
  changed_.notify_all();

  if (ready.pixels == nullptr) {
    std::snprintf(last_failure_.data(), last_failure_.size(), "%s: frame %llu: %s",
                  ready.frame->file.empty() ? index_.path.c_str() : ready.frame->file.c_str(),
                  static_cast<unsigned long long>(ready.frame->number), ready.error.text);
    return tl::unexpected<Error>(ready.error);
  }
  FrameLease lease(ready.buffer == kNoBuffer ? nullptr : this, ready.buffer);
  lease.frame.luma = ImageView{ready.pixels, size_.width_px, size_.height_px, size_.width_px};
  lease.frame.number = ready.number;
  lease.frame.set_exposure(ready.exposed_at);
  lease.frame.head = HeadAngles{ready.frame->pan_rad, ready.frame->tilt_rad};
  lease.frame.head_at = ready.exposed_at;
  lease.dropped_before = ready.dropped_before;
  return lease;
}

void RecordingSource::give_back(std::uint32_t buffer) noexcept {
  {
    const std::lock_guard lock(mutex_);
    free_[free_count_++] = buffer;
  }
  changed_.notify_all();
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

void RecordingSource::preload() {
  store_ = std::make_unique<std::uint8_t[]>(size_.pixel_count() * index_.frames.size());
  for (std::size_t i = 0; i < index_.frames.size(); ++i)
    preloaded_.push_back(
        reader_.read(index_.frames[i], std::span(store_.get() + i * size_.pixel_count(), size_.pixel_count())));
}

void RecordingSource::run() noexcept {
  std::uint64_t pass = 0;
  do {
    for (std::size_t i = 0; i < index_.frames.size(); ++i)
      if (!produce(i, pass)) return;
    ++pass;
  } while (options_.loop);
  const std::lock_guard lock(mutex_);
  finished_ = true;
  changed_.notify_all();
}

/// Sleeps until the frame's turn or until `is_enough`; before the first call of `next` there is no turn.
/// \return false: being destroyed
template <typename Condition>
bool RecordingSource::wait_for_turn(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds since_start,
                                    Condition is_enough) noexcept {
  changed_.wait(lock, [this] { return stop_ || started_at_.has_value(); });
  if (!stop_) changed_.wait_until(lock, *started_at_ + since_start, [&] { return stop_ || is_enough(); });
  return !stop_;
}

/// One frame, from its file into the queue. \return false: the source is being destroyed
bool RecordingSource::produce(std::size_t i, std::uint64_t pass) noexcept {
  const bool is_real_time = options_.pace == RecordingPace::kRealTime;
  const std::chrono::nanoseconds since_start = time_of(i, pass) - times_.front();
  ReadyFrame ready;
  ready.frame = &index_.frames[i];
  ready.number = ready.frame->number + pass * (index_.frames.back().number + 1);
  ready.exposed_at = MonoTime(time_of(i, pass));
  {
    std::unique_lock lock(mutex_);
    if (!is_real_time)
      changed_.wait(lock, [&] { return stop_ || (ready_count_ < kBufferCount && has_buffer()); });
    else if (!has_buffer() && !wait_for_turn(lock, since_start, [this] { return has_buffer(); }))
      return false;
    if (stop_) return false;
    const std::chrono::nanoseconds until_next =
        (i + 1 < times_.size() ? time_of(i + 1, pass) : time_of(0, pass + 1)) - times_.front();
    const bool is_late = is_real_time && started_at_ && mono_now() > *started_at_ + until_next;
    const std::optional<std::uint32_t> buffer = is_late ? std::nullopt : take_buffer();
    if (!buffer) {  // late, or the caller holds every buffer: this frame is lost, as it would be in a camera
      ++dropped_;
      return true;
    }
    ready.buffer = *buffer;
  }
  fill(ready, i);

  std::unique_lock lock(mutex_);
  if (is_real_time) {
    if (!wait_for_turn(lock, since_start, [] { return false; })) return false;
    ready.exposed_at = *started_at_ + since_start;
    if (ready_count_ > 0) drop_oldest_ready();
  }
  ready.dropped_before = std::exchange(dropped_, 0);
  if (ready.pixels == nullptr && ready.buffer != kNoBuffer) free_[free_count_++] = ready.buffer;
  ready_[(ready_begin_ + ready_count_++) % kBufferCount] = ready;
  lock.unlock();
  changed_.notify_all();
  return true;
}

/// A buffer to decode into, if need be that of a frame that nobody took in time. kNoBuffer when the pictures are
/// preloaded; nothing when the caller holds them all.
std::optional<std::uint32_t> RecordingSource::take_buffer() noexcept {
  if (!preloaded_.empty()) return kNoBuffer;
  if (free_count_ == 0 && ready_count_ > 0) drop_oldest_ready();
  if (free_count_ == 0) return std::nullopt;
  return free_[--free_count_];
}

void RecordingSource::drop_oldest_ready() noexcept {
  const ReadyFrame& oldest = ready_[ready_begin_];
  if (oldest.pixels != nullptr && oldest.buffer != kNoBuffer) free_[free_count_++] = oldest.buffer;
  dropped_ += oldest.dropped_before + 1;
  ready_begin_ = (ready_begin_ + 1) % kBufferCount;
  --ready_count_;
}

void RecordingSource::fill(ReadyFrame& ready, std::size_t i) noexcept {
  const std::size_t place = preloaded_.empty() ? ready.buffer : i;
  std::uint8_t* const pixels = store_.get() + place * size_.pixel_count();
  const Result<PictureSize> result =
      preloaded_.empty() ? reader_.read(*ready.frame, std::span(pixels, size_.pixel_count())) : preloaded_[i];
  if (result)
    ready.pixels = pixels;
  else
    ready.error = result.error();
}

}  // namespace ninedot
