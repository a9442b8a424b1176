#include "programs/web/recording_desk.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "base/startup_error.h"

namespace ninedot {
namespace {

// A report, and the row in frames.csv.
constexpr std::uint64_t kReport_bytes = 4096;

std::string text_of(const Error& error) {
  return error.os_errno == ENOSPC ? "the disk is full: delete recordings, or lower `recordings_mb` of [web]"
         : error.os_errno != 0    ? std::string(std::strerror(error.os_errno))
                                  : std::string(error.text);
}

}  // namespace

RecordingDesk::RecordingDesk(RecordingRules rules, RecordingShelf& shelf, std::function<void(const std::string&)> tell,
                             WriteFunction write_bytes)
    : rules_(rules), shelf_(shelf), tell_(std::move(tell)), write_bytes_(write_bytes), ring_(rules.loss) {}

void RecordingDesk::note(const std::string& text) {
  note_ = text;
  tell_(text);
}

std::string RecordingDesk::full_text() const {
  if (shelf_.is_full()) return fmt::format("{} recordings are as many as are kept: delete some", RecordingShelf::kMost);
  return fmt::format("{} MB, `recordings_mb` of [web], are full: delete recordings", rules_.most_bytes / 1'000'000);
}

bool RecordingDesk::has_room(std::uint64_t bytes) const noexcept {
  const std::uint64_t running = (asked_ ? asked_->entry().bytes : 0) + (loss_ ? loss_->entry().bytes : 0);
  return shelf_.bytes() + running + bytes <= rules_.most_bytes && !shelf_.is_full();
}

void RecordingDesk::start(MonoTime now) {
  if (is_asked()) return;
  note_.clear();
  is_awaited_ = true;
  heard_at_ = now;
}

void RecordingDesk::stop(std::string_view why) {
  is_awaited_ = false;
  if (!asked_) return;
  if (auto entry = asked_->end(why)) shelf_.add(std::move(*entry));
  asked_.reset();
}

void RecordingDesk::end_asked(const std::string& why) {
  note(asked_ && asked_->entry().frames > 0 ? fmt::format("{} ended by itself: {}", asked_->entry().name, why)
                                            : fmt::format("Nothing was recorded: {}", why));
  stop(why);
}

void RecordingDesk::remove(std::string_view name) {
  note_.clear();
  shelf_.remove(name);
}

void RecordingDesk::begin(const TapHeader& header) {
  try {
    asked_.emplace(shelf_.path_of(shelf_.free_name(RecordingCause::kAsked)), header, write_bytes_);
    next_bytes_ = std::uint64_t{header.width_px} * header.height_px;
    is_awaited_ = false;
  } catch (const StartupError& error) {
    end_asked(error.what());
  }
}

void RecordingDesk::record(const TapCopy& copy) {
  if (!has_room(next_bytes_ + kReport_bytes)) return end_asked(full_text());
  const Result<std::uint64_t> written = asked_->add(copy);
  if (!written) return end_asked(text_of(written.error()));
  next_bytes_ = *written;
  if (asked_->entry().duration >= rules_.longest)
    end_asked(fmt::format("{:%Q} s, `recording_s` of [web], are over",
                          std::chrono::duration_cast<std::chrono::seconds>(rules_.longest)));
}

void RecordingDesk::take(QueuedFrame& frame, MonoTime now) {
  heard_at_ = now;
  if (frame.header != header_) {
    if (asked_) end_asked("the service was started again");
    if (!loss_) ring_.reset();
    header_ = frame.header;
  }
  if (!frame.copy.luma().empty()) {
    if (is_awaited_) begin(*frame.header);
    if (asked_) record(frame.copy);
  }
  if (!keeps_losses()) return;
  ring_.take(frame.copy, frame.header->rate_hz);
  if (ring_.phase() == LossRing::Phase::kReady && !loss_) begin_saving();
}

void RecordingDesk::wait(MonoTime now, std::string_view trouble) {
  if (now - heard_at_ < kPatience) return;
  if (is_asked())
    end_asked(trouble.empty() ? "no frame for 3 s: `ninedot status` says how the camera is" : std::string(trouble));
  ring_.expire();
  if (ring_.phase() == LossRing::Phase::kReady && !loss_) begin_saving();
}

void RecordingDesk::begin_saving() {
  while (rules_.most_losses > 0 && shelf_.losses() >= rules_.most_losses) shelf_.remove_oldest_loss();
  saved_ = 0;
  try {
    loss_.emplace(shelf_.path_of(shelf_.free_name(RecordingCause::kLoss)), *header_, write_bytes_);
  } catch (const StartupError& error) {
    note(fmt::format("A loss could not be kept: {}", error.what()));
    ring_.release();
  }
}

void RecordingDesk::end_saving(std::string_view why) {
  const std::size_t frames = loss_->entry().frames;
  if (auto entry = loss_->end(why)) shelf_.add(std::move(*entry));
  tell_(fmt::format("{}: the landmark was lost, {} frames: {}", loss_->entry().name, frames, why));
  loss_.reset();
  ring_.release();
}

bool RecordingDesk::save_one() {
  if (!loss_) return false;
  if (saved_ == ring_.size()) {
    end_saving("complete");
    return false;
  }
  const TapCopy& copy = ring_.at(saved_++);
  while (!has_room(copy.pixels.size() + kReport_bytes))
    if (!shelf_.remove_oldest_loss()) {
      end_saving(full_text());
      return false;
    }
  if (const Result<std::uint64_t> written = loss_->add(copy); !written) {
    end_saving(text_of(written.error()));
    return false;
  }
  return true;
}

void RecordingDesk::close() {
  stop("ninedot-web ended");
  if (loss_) end_saving("ninedot-web ended while it was saved");
}

RecordingState RecordingDesk::state() const {
  RecordingState state;
  state.entries = shelf_.entries();
  if (asked_) state.running = asked_->entry();
  state.is_awaited = is_awaited_;
  state.note = note_;
  state.bytes = shelf_.bytes() + (asked_ ? asked_->entry().bytes : 0) + (loss_ ? loss_->entry().bytes : 0);
  state.most_bytes = rules_.most_bytes;
  state.longest = rules_.longest;
  state.keeps_losses = keeps_losses();
  state.is_saving = loss_.has_value();
  state.phase = ring_.phase();
  state.before = rules_.loss.before;
  state.spacing = ring_.spacing();
  state.skipped = ring_.skipped();
  state.ring_bytes = ring_.bytes();
  return state;
}

}  // namespace ninedot
