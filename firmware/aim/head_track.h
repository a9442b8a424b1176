#pragma once
/// Where a head has stood, and when: a frame was exposed some time ago, and is of where the head stood then.
#include <array>
#include <chrono>
#include <cstddef>

#include "base/head_angles.h"
#include "base/mono_time.h"

namespace ninedot {

/// Between its stamps a head is taken to have turned evenly. Memory: inside; trivially copyable. Threads: one.
class HeadTrack {
 public:
  /// \param head  where it stands, and has always stood
  explicit HeadTrack(const HeadAngles& head) noexcept { past_[0].head = head; }
  HeadTrack() noexcept = default;  ///< straight ahead

  /// \param at  not before the time of the one before; may lie ahead, where a head follows its commands late
  void add(MonoTime at, const HeadAngles& head) noexcept {
    newest_ = (newest_ + 1) % past_.size();
    past_[newest_] = {at, head};
    if (count_ < past_.size()) ++count_;
  }

  /// Where it stood at `time`; for times beyond those that are remembered the newest or the oldest.
  HeadAngles at(MonoTime time) const noexcept {
    if (past_[newest_].at <= time) return newest();
    for (std::size_t back = 1; back < count_; ++back) {
      const Past &before = past(back), &after = past(back - 1);
      if (before.at > time) continue;
      // Until the first stamp it has always stood where it was.
      if (before.at == MonoTime{} || after.at <= before.at) return before.head;
      const double part = seconds(time - before.at) / seconds(after.at - before.at);
      return {before.head.pan_rad + part * (after.head.pan_rad - before.head.pan_rad),
              before.head.tilt_rad + part * (after.head.tilt_rad - before.head.tilt_rad)};
    }
    return past(count_ - 1).head;
  }
  HeadAngles newest() const noexcept { return past_[newest_].head; }

 private:
  struct Past {
    MonoTime at{};  // MonoTime{}: from ever
    HeadAngles head;
  };
  static double seconds(std::chrono::nanoseconds time) noexcept { return std::chrono::duration<double>(time).count(); }
  const Past& past(std::size_t back) const noexcept { return past_[(newest_ + past_.size() - back) % past_.size()]; }

  // About a second of steps, one per frame and per 10 ms: longer than any latency that a pose may be used with.
  std::array<Past, 160> past_{};
  std::size_t newest_ = 0, count_ = 1;
};

}  // namespace ninedot
