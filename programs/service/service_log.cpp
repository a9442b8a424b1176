#include "programs/service/service_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "drivers/posix/print_patiently.h"
#include "programs/display/live_display.h"

namespace ninedot {
namespace {

// Of the main thread, which carries out commands and hears signals as well: five of its rounds.
constexpr std::chrono::milliseconds kPatience{100};

bool comes_from_the_source(Reason reason) noexcept {
  return reason == Reason::kCameraLost || reason == Reason::kFrameSize || reason == Reason::kFrameUnreadable;
}

}  // namespace

void ServiceLog::write(const std::string& line) {
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
  if (seen_ == said_ || (said_ != Reason::kStarting && now - seen_since_ < kSettle)) return;
  said_ = seen_;
  if (seen_ == Reason::kNone) {
    write(fmt::format("landmark {} found at {:.3f} m", report.landmark_id, report.distance_m));
    return;
  }
  std::string line(reason_sentence(seen_));
  if (comes_from_the_source(seen_) && *last_error.text != '\0') {
    line += fmt::format(": {}", last_error.text);
    if (last_error.os_errno != 0) line += fmt::format(" ({})", std::strerror(last_error.os_errno));
  }
  write(line);
}

void ServiceLog::note_device(const std::string& name, const std::string& problem, const std::string& description,
                             MonoTime now) {
  Device& device = devices_[name];
  const bool is_in_use = problem.empty();
  if (is_in_use != device.is_in_use || !device.is_known) device.since = now;
  device.is_in_use = is_in_use;
  if (device.is_known && (device.was_in_use == is_in_use || now - device.since < kSettle)) return;
  const bool is_first = !device.is_known;
  device.is_known = true;
  device.was_in_use = is_in_use;
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
