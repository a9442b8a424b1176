#include "programs/service/service_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "drivers/posix/print_patiently.h"
#include "programs/assembly/row_time_text.h"
#include "programs/display/live_display.h"
#include "programs/log_text.h"

namespace ninedot {
namespace {

// Of the main thread, which carries out commands and hears signals as well: five of its rounds.
constexpr std::chrono::milliseconds kPatience{100};

bool comes_from_the_source(Reason reason) noexcept {
  return reason == Reason::kCameraLost || reason == Reason::kFrameSize || reason == Reason::kFrameUnreadable;
}

std::string text_of(const Error& error) {
  if (error.os_errno == 0) return error.text;
  return fmt::format("{} ({})", error.text, std::strerror(error.os_errno));
}

}  // namespace

bool ServiceLog::Cause::is_another(const std::string& cause, MonoTime now) {
  if (cause != seen_) {
    seen_ = cause;
    since_ = now;
  }
  if (seen_ == said_ || now - since_ < kOtherCause) return false;
  said_ = seen_;
  return true;
}

void ServiceLog::write(const std::string& text) {
  const std::string line = log_text(text);
  if (listener_ != nullptr) listener_->on_line(line, mono_now());
  if (display_ != nullptr) display_->make_room();
  // A log that nobody takes is no reason to stop, or to wait: the line is lost, and the registers say what is.
  static_cast<void>(print_patiently(STDERR_FILENO, fmt::format("ninedotd: {}\n", line), kPatience));
}

void ServiceLog::note_camera_absent(const std::string& refusal) {
  said_ = seen_ = Reason::kCameraLost;
  write("camera: waits for it: " + refusal);
}

void ServiceLog::note(const Report& report, const Error& last_error, MonoTime now) {
  if (report.reason != seen_) {
    seen_ = report.reason;
    seen_since_ = now;
  }
  const bool has_cause = comes_from_the_source(seen_) && *last_error.text != '\0';
  if (seen_ == said_) {
    if (!has_cause) return;
    if (!is_source_cause_known_) source_cause_.say(text_of(last_error));  // the start has told it in its own words
    is_source_cause_known_ = true;
    if (source_cause_.is_another(text_of(last_error), now))
      write(fmt::format("{}: {}", reason_sentence(seen_), text_of(last_error)));
    return;
  }
  if (said_ != Reason::kStarting && now - seen_since_ < kSettle) return;
  said_ = seen_;
  is_source_cause_known_ = has_cause;
  if (has_cause) source_cause_.say(text_of(last_error));
  if (seen_ == Reason::kNone) {
    write(fmt::format("landmark {} found at {:.3f} m", report.landmark_id, report.distance_m));
    return;
  }
  write(has_cause ? fmt::format("{}: {}", reason_sentence(seen_), text_of(last_error))
                  : std::string(reason_sentence(seen_)));
}

void ServiceLog::note_row_time(const RowTime& rows) {
  if (rows.source == said_row_time_) return;
  said_row_time_ = rows.source;
  if (const std::string text = row_time_text(rows); !text.empty()) write(text);
}

bool ServiceLog::Lasting::is_news(MonoTime now) {
  if (last_ == MonoTime{} || now - last_ > (is_said_ ? MonoTime::duration(kWasWell) : MonoTime::duration(kSettle)))
    since_ = now, is_said_ = false;
  last_ = now;
  if (is_said_ || now - since_ < kSettle) return false;
  return is_said_ = true;
}

void ServiceLog::note_misplaced(const Report& report, MonoTime now) {
  if (report.landmarks_rejected > 0 && misplaced_[report.last_rejected_id].is_news(now))
    write(fmt::format("landmark {} does not hang where the map says: poses are made without it; measure its place",
                      report.last_rejected_id));
  if (report.landmarks_disputed > 1 && disputed_[report.disputed_ids].is_news(now))
    write(
        fmt::format("landmarks {} and {} contradict each other: one of them does not hang where the map says; measure "
                    "both",
                    report.disputed_ids[0], report.disputed_ids[1]));
}

void ServiceLog::note_device(const std::string& name, const std::string& problem, const std::string& description,
                             MonoTime now) {
  Device& device = devices_[name];
  const bool is_in_use = problem.empty();
  if (is_in_use != device.is_in_use || !device.is_known) device.since = now;
  device.is_in_use = is_in_use;
  if (device.is_known && device.was_in_use == is_in_use) {
    if (!is_in_use && device.cause.is_another(problem, now))
      write(fmt::format("{}: still waits for it: {}", name, problem));
    return;
  }
  if (device.is_known && now - device.since < kSettle) return;
  const bool is_first = !device.is_known;
  device.is_known = true;
  device.was_in_use = is_in_use;
  device.cause.say(problem);
  if (!is_in_use)
    write(fmt::format("{}: {}, waits for it: {}", name, is_first ? "not there" : "gone", problem));
  else if (!description.empty())
    write(fmt::format("{}: {}", name, description));
  else if (!is_first)
    write(fmt::format("{}: there", name));
}

void ServiceLog::note_series(const std::string& what, std::uint64_t count, const std::string& last, MonoTime now) {
  Series& series = series_[what];
  if (count == series.said || (series.said != 0 && now - series.said_at < kSeriesPeriod)) return;
  const std::string details =
      last.empty() ? "" : fmt::format(": {}{}", count - series.said == 1 ? "" : "the last one ", last);
  write(series.said == 0 ? fmt::format("{} {}{}", count, what, details)
                         : fmt::format("{} more {} since{}", count - series.said, what, details));
  series.said = count;
  series.said_at = now;
}

}  // namespace ninedot
