// One turn: ask for the newest frame, process it, publish, give the buffer back. Whatever goes wrong becomes a report
// that is not valid and says why. Nothing is logged here: a real-time thread must not wait for whoever reads the log;
// the main thread sees the reasons change and writes them down.
#include "pipeline/frame_loop.h"

#include <latch>
#include <limits>

#include "pipeline/next_report.h"
#include "pipeline/report_reason.h"

namespace ninedot {

FrameLoop::FrameLoop(FrameSource& source, FrameProcessor& processor, Mailbox<Report>& reports, Mailbox<Health>& health,
                     const FrameLoopOptions& options)
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
  // The outputs read from here on: whoever asks before the first frame hears already whether there is a head.
  look_at_head();
  publish(report_of_head(report_, {last_frame_at_, head_}));
  healths_.publish(health_);
}

Result<void> FrameLoop::start(FrameThread& thread) {
  Result<void> realtime;
  std::latch entered(1);
  thread_ = std::jthread([&](const std::stop_token& stop) {
    realtime = thread.enter();
    health_.realtime = realtime.has_value();
    publish_health(mono_now());
    entered.count_down();
    // Also when the source is over: the head goes on, and the rate falls to 0.
    while (!stop.stop_requested()) step();
  });
  entered.wait();
  return realtime;
}

void FrameLoop::stop() noexcept {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

bool FrameLoop::step() noexcept {
  turns_.fetch_add(1, std::memory_order_relaxed);
  const MonoTime asked_at = mono_now();
  if (over()) {
    std::this_thread::sleep_until(asked_at + options_.wait);
    look_at_head();
    on_no_news();
  } else {
    Result<FrameLease> lease = source_.next(asked_at + options_.wait);
    if (lease)
      on_frame(*lease);
    else
      on_failure(lease.error(), asked_at);
  }
  const MonoTime now = mono_now();
  if (now - health_at_ >= options_.health_period || report_.reason != published_reason_) publish_health(now);
  return !over();
}

void FrameLoop::on_frame(FrameLease& lease) noexcept {
  if (options_.zoom_of_head) {
    look_at_head();
    lease.frame.zoom = zoom_at(lease.frame.exposed_at());
  }
  const Fix& fix = processor_.process(lease.frame);
  look_at_head();
  last_frame_at_ = mono_now();
  publish(next_report(report_, lease.frame, fix, {mono_now(), head_, lease.dropped_before, &options_.body}));
  if (options_.observer != nullptr) options_.observer->observe(lease.frame, fix, processor_, report_);
  if (report_.reason == Reason::kFrameSize) return;
  latency_.add(report_.latency);
  frames_processed_.fetch_add(1, std::memory_order_relaxed);
}

void FrameLoop::on_failure(const Error& error, MonoTime asked_at) noexcept {
  look_at_head();
  const MonoTime now = mono_now();
  if (error.code == Errc::kNoFrame) {
    if (now - last_frame_at_ < options_.stall_after || report_.reason == Reason::kCameraLost) return on_no_news();
    last_error_.publish(Error{Errc::kCameraLost, 0, "the camera delivers no frames"});
    return publish(report_of_failure(report_, Reason::kCameraLost, {now, head_}));
  }
  if (error.code == Errc::kFrameUnreadable || error.code == Errc::kFrameSize) last_frame_at_ = now;
  last_error_.publish(error);
  publish(report_of_failure(report_, reason_of(error.code), {now, head_}));
  if (error.code == Errc::kEndOfStream)
    over_.store(true, std::memory_order_relaxed);
  else
    std::this_thread::sleep_until(asked_at + options_.failure_pause);
}

void FrameLoop::look_at_head() noexcept { head_ = options_.head != nullptr ? &options_.head->take() : nullptr; }

double FrameLoop::zoom_at(MonoTime time) const noexcept {
  return head_ != nullptr && head_->zoom ? head_->zoom->at(time) : std::numeric_limits<double>::quiet_NaN();
}

void FrameLoop::on_no_news() noexcept {
  // A valid report shows the head of its exposure; it does not become another one afterwards.
  if (head_ == nullptr || report_.valid) return;
  const Report report = report_of_head(report_, {mono_now(), head_});
  if (report.head != report_.head) publish(report);
}

void FrameLoop::publish(const Report& report) noexcept {
  report_ = report;
  reports_.publish(report_);
}

void FrameLoop::publish_health(MonoTime now) noexcept {
  const std::chrono::duration<double> elapsed_s = now - health_at_;
  if (now - health_at_ >= options_.health_period) {
    health_.frame_rate_hz = (report_.frames.processed - processed_at_health_) / elapsed_s.count();
    health_at_ = now;
    health_.rate_holds_until = now + 2 * options_.health_period;
    processed_at_health_ = report_.frames.processed;
  }
  health_.has_latency = report_.frames.processed != 0;
  health_.latency_median = latency_.quantile(0.5);
  health_.latency_p99 = latency_.quantile(0.99);
  health_.latency_p999 = latency_.quantile(0.999);
  health_.latency_max = latency_.max();
  const SourceCounters counters = source_.counters();
  health_.camera_restarts = counters.restarts;
  health_.frames_flagged = counters.flagged;
  if (head_ != nullptr) {
    health_.head_losses = head_->losses;
    health_.servos = head_->servos;
    health_.pulse_error_p99 = head_->pulse_error_p99;
    health_.pulse_error_max = head_->pulse_error_max;
  }
  health_.temperature_degC = temperature_degC_.load(std::memory_order_relaxed);
  published_reason_ = report_.reason;
  healths_.publish(health_);
}

}  // namespace ninedot
