#include "programs/service/service_log.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "programs/display/live_display.h"

namespace ninedot {
namespace {

bool comes_from_the_source(Reason reason) noexcept {
  return reason == Reason::kCameraLost || reason == Reason::kFrameSize || reason == Reason::kFrameUnreadable;
}

}  // namespace

void ServiceLog::write(const std::string& line) {
  if (display_ != nullptr) display_->make_room();
  fmt::print(stderr, "ninedotd: {}\n", line);
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

}  // namespace ninedot
