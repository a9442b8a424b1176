#pragma once
/// A stand-in for the frame loop: every value of its reports follows from the pose sequence.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "tests/proto/wire_box.h"

namespace ninedot::test {

/// The report number `sequence`: x = sequence mm, y = -sequence mm, z = 2 sequence mm, and so on.
inline WireReport report_number(std::uint32_t sequence) {
  const double n = static_cast<double>(sequence % 30000);
  WireReport report;
  report.frames_processed = report.pose_sequence = sequence;
  report.valid = report.found = report.has_pose = true;
  report.reason = Reason::kNone;
  report.exposed_at = mono_now();
  report.landmark_id = static_cast<std::uint16_t>(sequence);
  report.pose = {{n, -n, 2 * n}, {1, 0, 0, 0}};
  report.sigma_mm = {n * 1e-2, n * 1e-2, n * 1e-2};
  report.sigma_deg = {n * 1e-4, n * 1e-4, n * 1e-4};
  report.dots_used = static_cast<std::uint16_t>(sequence);
  return report;
}

class Publisher {
 public:
  Publisher(WireBox& reports, double rate_hz) : thread_([this, &reports, rate_hz] { run(reports, rate_hz); }) {}
  ~Publisher() {
    stop_ = true;
    thread_.join();
  }
  /// The longest that `publish` itself has taken: what a client could have cost the frame loop.
  std::chrono::nanoseconds longest_publish() const { return std::chrono::nanoseconds(longest_ns_.load()); }
  std::uint32_t published() const { return published_; }

 private:
  void run(WireBox& reports, double rate_hz) {
    const std::chrono::nanoseconds period(static_cast<std::int64_t>(1e9 / rate_hz));
    for (MonoTime next = mono_now(); !stop_; next += period) {
      const WireReport report = report_number(++published_);
      const MonoTime before = mono_now();
      reports.publish(report);
      longest_ns_ = std::max<std::int64_t>(longest_ns_, (mono_now() - before).count());
      std::this_thread::sleep_until(next + period);
    }
  }
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> longest_ns_{0};
  std::atomic<std::uint32_t> published_{0};
  std::thread thread_;
};

}  // namespace ninedot::test
