#pragma once
/// The loop that turns frames into reports, on its own thread: source -> processor -> publish -> buffer given back.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "aim/head_snapshot.h"
#include "base/handoff.h"
#include "base/mailbox.h"
#include "base/result.h"
#include "geometry/body.h"
#include "pipeline/frame_observer.h"
#include "pipeline/frame_processor.h"
#include "pipeline/latency_histogram.h"
#include "ports/frame_source.h"
#include "ports/frame_thread.h"
#include "report/health.h"
#include "report/report.h"

namespace ninedot {

struct FrameLoopOptions {
  std::chrono::nanoseconds wait = std::chrono::milliseconds(100);         ///< for one frame; bounds the time to stop
  std::chrono::nanoseconds stall_after = std::chrono::seconds(1);         ///< no frame for so long: the camera is lost
  std::chrono::nanoseconds health_period = std::chrono::seconds(1);       ///< between two publications of Health
  std::chrono::nanoseconds failure_pause = std::chrono::milliseconds(5);  ///< least time between two failed attempts
  bool memory_locked = false;                                             ///< passed on in Health
  BodyGeometry body{};                                                    ///< where the camera sits on the robot
  Handoff<HeadSnapshot>* head = nullptr;  ///< what the head does, of its own thread; null: there is no head
  bool zoom_of_head = false;              ///< where the zoom stands in a frame the head says, not the source
  FrameObserver* observer = nullptr;      ///< shown each processed frame; null: nobody looks on
};

/// Memory: everything before start(); nothing is allocated per frame. Threads: see each method. The references given to
/// the constructor must outlive the loop.
class FrameLoop {
 public:
  FrameLoop(FrameSource& source, FrameProcessor& processor, Mailbox<Report>& reports, Mailbox<Health>& health,
            const FrameLoopOptions& options = {});
  ~FrameLoop() { stop(); }
  FrameLoop(const FrameLoop&) = delete;
  FrameLoop& operator=(const FrameLoop&) = delete;

  /// Starts the thread and waits until it has asked `thread` for real-time priority.
  /// \error  kIo: it runs, without; os_errno says why. Threads: the owner.
  Result<void> start(FrameThread& thread);

  /// Ends the thread within FrameLoopOptions::wait. Harmless when it does not run. Threads: the owner.
  void stop() noexcept;

  /// One turn of the loop, for the thread and for tests: at most one frame, always one published report when there was
  /// something to say. A failure is published as a report that is not valid, with the reason.
  /// \return  false when the source is over: no frame will follow, only what the head does.
  /// Threads: the loop's own; the owner while it does not run.
  bool step() noexcept;

  /// Turns of the loop, with a frame or without: grows while its thread lives, also while the camera is lost. A
  /// watchdog is fed only while this grows. Threads: any.
  std::uint64_t turns() const noexcept { return turns_.load(std::memory_order_relaxed); }
  /// Frames that came all the way through. Threads: any.
  std::uint64_t frames_processed() const noexcept { return frames_processed_.load(std::memory_order_relaxed); }
  /// The source has ended for good (a recording that does not loop). Threads: any.
  bool over() const noexcept { return over_.load(std::memory_order_relaxed); }
  /// The newest failure of the source, for the log; code 0 while there was none. Threads: any ordinary one.
  Error last_error() const noexcept { return last_error_.read(); }
  /// The board's temperature for Health; NaN where unknown. Threads: any.
  void set_temperature(double degC) noexcept { temperature_degC_.store(degC, std::memory_order_relaxed); }

 private:
  void on_frame(FrameLease& lease) noexcept;
  void on_failure(const Error& error, MonoTime asked_at) noexcept;
  void look_at_head() noexcept;
  double zoom_at(MonoTime time) const noexcept;
  void on_no_news() noexcept;
  void publish(const Report& report) noexcept;
  void publish_health(MonoTime now) noexcept;

  FrameSource& source_;
  FrameProcessor& processor_;
  Mailbox<Report>& reports_;
  Mailbox<Health>& healths_;
  const FrameLoopOptions options_;

  const HeadSnapshot* head_ = nullptr;  // newest, of this turn; null: there is no head
  Report report_{};                     // as published
  Health health_{};
  LatencyHistogram latency_;
  MonoTime last_frame_at_;
  MonoTime health_at_;                     // of the newest publication
  std::uint32_t processed_at_health_ = 0;  // frames processed by then
  Reason published_reason_ = Reason::kStarting;

  std::atomic<std::uint64_t> frames_processed_{0};
  std::atomic<std::uint64_t> turns_{0};
  std::atomic<bool> over_{false};
  std::atomic<double> temperature_degC_;
  Mailbox<Error> last_error_;
  std::jthread thread_;  // last: ends before anything it uses
};

}  // namespace ninedot
