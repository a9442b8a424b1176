#pragma once
/// Where a head has stood, and when: a frame was exposed some time ago, and is of where the head stood then.
#include <array>
#include <cstddef>

#include "base/head_angles.h"
#include "base/mono_time.h"

namespace ninedot {

/// Memory: inside; trivially copyable. Threads: one.
class HeadTrack {
 public:
  /// \param head  where it stands, and has always stood
  explicit HeadTrack(const HeadAngles& head) noexcept { past_[0].head = head; }
  HeadTrack() noexcept = default;  ///< straight ahead

  /// \param at  not before the time of the one before
  void add(MonoTime at, const HeadAngles& head) noexcept {
    newest_ = (newest_ + 1) % past_.size();
    past_[newest_] = {at, head};
    if (count_ < past_.size()) ++count_;
  }

  /// The newest that is not after `time`; the oldest that is remembered for times before it.
  HeadAngles at(MonoTime time) const noexcept {
    HeadAngles head = newest();
    for (std::size_t back = 0; back < count_; ++back) {
      const Past& past = past_[(newest_ + past_.size() - back) % past_.size()];
      head = past.head;
      if (past.at <= time) break;
    }
    return head;
  }
  HeadAngles newest() const noexcept { return past_[newest_].head; }

 private:
  struct Past {
    MonoTime at{};
    HeadAngles head;
  };
  // About a second of frames: longer than any latency that a pose may be used with.
  std::array<Past, 32> past_{};
  std::size_t newest_ = 0, count_ = 1;
};

}  // namespace ninedot
