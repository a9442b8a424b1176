// One turn: ask for the newest frame, process it, publish, give the buffer back. Whatever goes wrong becomes a report
// that is not valid and says why. Nothing is logged here: a real-time thread must not wait for whoever reads the log;
// the main thread sees the reasons change and writes them down.
#include "pipeline/frame_loop.h"

#include <latch>
#include <limits>
#include <utility>

#include "pipeline/next_report.h"
#include "pipeline/report_reason.h"

namespace ninedot {

FrameLoop::FrameLoop(FrameSource& source, FrameProcessor& processor, Mailbox<Report>& reports,
                     Mailbox<Health>& health, const FrameLoopOptions& options)
    : source_(source),
      processor_(processor),
      reports_(reports),
      healths_(health),
      options_(options),
      last_frame_at_(mono_now()),
      health_at_(last_frame_at_),
      temperature_degC_(std::numeric_limits<double>::quiet_NaN()) {
  health_.started_at = last_frame_at_;
  health_.memory_locked = options.memory_locked;
  health_.temperature_degC = std::numeric_limits<double>::quiet_NaN();
  reports_.publish(report_);
  healths_.publish(health_);
}

int FrameLoop::start(FrameThread& thread) {
  int refused_errno = 0;
  std::latch entered(1);
  thread_ = std::jthread([&](const std::stop_token& stop) {
    refused_errno = thread.enter();
    health_.realtime = refused_errno == 0;
    publish_health(mono_now());
    entered.count_down();
    while (!stop.stop_requested() && step()) {
    }
  });
  entered.wait();
  return refused_errno;
}

void FrameLoop::stop() noexcept {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

bool FrameLoop::step() noexcept {
  turns_.fetch_add(1, std::memory_order_relaxed);
  const MonoTime asked_at = mono_now();
  {
    const Result<FrameLease> lease = source_.next(asked_at + options_.wait);
    if (lease)
      on_frame(*lease);
    else
      on_failure(lease.error(), asked_at);
  }
  if (options_.head != nullptr) options_.head->move();
  const MonoTime now = mono_now();
  if (now - health_at_ >= options_.health_period || report_.reason != published_reason_) publish_health(now);
  return !over();
}

void FrameLoop::on_frame(const FrameLease& lease) noexcept {
  health_.frames_dropped += lease.dropped_before;
  report_ = next_report(report_, lease.frame, processor_.process(lease.frame));
  if (options_.head != nullptr) options_.head->aim(mono_now(), report_);
  last_frame_at_ = mono_now();
  if (report_.reason == Reason::kFrameSize) {
    ++health_.frames_failed;
    publish();
    return;
  }
  report_.latency = mono_now() - lease.frame.exposed_at();
  publish();
  latency_.add(report_.latency);
  ++health_.frames_processed;
  frames_processed_.fetch_add(1, std::memory_order_relaxed);
}

void FrameLoop::on_failure(const Error& error, MonoTime asked_at) noexcept {
  const MonoTime now = mono_now();
  if (error.code == Errc::kNoFrame) {
    if (now - last_frame_at_ < options_.stall_after || report_.reason == Reason::kCameraLost) return aim_blindly(now);
    last_error_.publish(Error{Errc::kCameraLost, 0, "the camera delivers no frames"});
    mark_invalid(Reason::kCameraLost, report_);
    aim_blindly(now);
    publish();
    return;
  }
  if (error.code == Errc::kFrameUnreadable || error.code == Errc::kFrameSize) {
    ++health_.frames_failed;
    last_frame_at_ = now;
  }
  last_error_.publish(error);
  mark_invalid(reason_of(error.code), report_);
  aim_blindly(now);
  publish();
  if (error.code == Errc::kEndOfStream)
    over_.store(true, std::memory_order_relaxed);
  else
    std::this_thread::sleep_until(asked_at + options_.failure_pause);
}

void FrameLoop::aim_blindly(MonoTime now) noexcept {
  if (options_.head == nullptr) return;
  // The report may still be that of a frame long processed: nothing may be followed by it.
  const bool valid = std::exchange(report_.valid, false);
  options_.head->aim(now, report_);
  report_.valid = valid;
}

void FrameLoop::publish() noexcept {
  report_.published_at = mono_now();
  reports_.publish(report_);
}

void FrameLoop::publish_health(MonoTime now) noexcept {
  const std::chrono::duration<double> elapsed_s = now - health_at_;
  if (now - health_at_ >= options_.health_period) {
    health_.frame_rate_hz = (health_.frames_processed - processed_at_health_) / elapsed_s.count();
    health_at_ = now;
    processed_at_health_ = health_.frames_processed;
  }
  health_.latency_median = latency_.quantile(0.5);
  health_.latency_p99 = latency_.quantile(0.99);
  health_.latency_p999 = latency_.quantile(0.999);
  health_.latency_max = latency_.max();
  const SourceCounters counters = source_.counters();
  health_.camera_restarts = counters.restarts;
  health_.frames_failed += counters.flagged - std::exchange(flagged_at_health_, counters.flagged);
  if (options_.head != nullptr) {
    const HeadState head = options_.head->state();
    health_.pulse_error_p99 = head.pulse_error_p99;
    health_.pulse_error_max = head.pulse_error_max;
  }
  health_.temperature_degC = temperature_degC_.load(std::memory_order_relaxed);
  published_reason_ = report_.reason;
  healths_.publish(health_);
}

}  // namespace ninedot
