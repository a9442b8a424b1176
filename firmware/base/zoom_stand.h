#pragma once
/// Where a zoom lens stands still, by what its camera answers when it is asked from time to time.
#include <chrono>
#include <cstdlib>
#include <limits>
#include <optional>

#include "base/mono_time.h"

namespace ninedot {

struct ZoomStand {
  int position = 0;    ///< [steps]
  MonoTime since{};    ///< it has stood there from then on at the latest
  MonoTime told_at{};  ///< of the newest answer

  /// So long an answer holds: several questions may go unanswered before.
  static constexpr std::chrono::milliseconds kHolds{1000};

  /// The position at `time` [steps]; NaN: it was on its way, or nothing has been heard for too long.
  double at(MonoTime time) const noexcept {
    const bool is_known = time >= since && time - told_at <= kHolds;
    return is_known ? position : std::numeric_limits<double>::quiet_NaN();
  }
};

/// Answers as they come. Memory: inside. Threads: one.
class ZoomAnswers {
 public:
  /// A lens that stands between two steps may be told as one or the other.
  static constexpr int kSame_steps = 1;

  void add(int position, MonoTime now) noexcept {
    if (!first_ || std::abs(position - first_->position) > kSame_steps) {
      first_ = ZoomStand{position, now, now};
      stands_ = false;
      return;
    }
    first_->told_at = now;
    stands_ = true;
  }
  void forget() noexcept { first_.reset(), stands_ = false; }

  /// None: it is on its way, or only one answer is there, which does not tell.
  std::optional<ZoomStand> stand() const noexcept { return stands_ ? first_ : std::nullopt; }

 private:
  std::optional<ZoomStand> first_;  // as told by the first answer of those that agree
  bool stands_ = false;
};

}  // namespace ninedot
