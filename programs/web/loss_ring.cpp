#include "programs/web/loss_ring.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ninedot {

void LossRing::take(TapCopy& copy, double rate_hz) {
  if (phase_ == Phase::kReady) return;
  judge(copy.frame);
  if (copy.luma().empty()) return;
  if (copy.pixels.size() > frame_bytes_) plan(copy.pixels.size(), rate_hz);
  // A frame that comes a little early is still the next one.
  if (count_ == 0 || copy.frame.exposed_at_ns - kept_at_ns_ >= spacing_.count() * 9 / 10) keep(copy);
}

void LossRing::plan(std::size_t frame_bytes, double rate_hz) {
  const std::chrono::duration<double> span = rules_.before + rules_.after;
  const auto wanted = static_cast<std::size_t>(std::ceil(span.count() * std::clamp(rate_hz, 1.0, 1000.0))) + 1;
  const std::size_t fitting = std::max<std::size_t>(rules_.most_bytes / frame_bytes, 1);
  slots_ = std::vector<TapCopy>(std::min(wanted, fitting));
  for (TapCopy& slot : slots_) slot.pixels.resize(frame_bytes);
  frame_bytes_ = frame_bytes;
  first_ = count_ = 0;
  spacing_ = wanted <= fitting ? std::chrono::nanoseconds(0)
                               : (rules_.before + rules_.after) / static_cast<std::int64_t>(fitting);
}

void LossRing::keep(TapCopy& copy) {
  if (count_ == slots_.size()) {
    first_ = (first_ + 1) % slots_.size();
    --count_;
  }
  kept_at_ns_ = copy.frame.exposed_at_ns;
  std::swap(slots_[(first_ + count_++) % slots_.size()], copy);
}

void LossRing::judge(const TapFrame& frame) {
  const std::int64_t at_ns = frame.exposed_at_ns;
  if (phase_ == Phase::kLost) {
    if (at_ns - valid_at_ns_ >= rules_.after.count()) phase_ = Phase::kReady;
    return;
  }
  if ((frame.flags & tap_flag::kValid) != 0) {
    phase_ = Phase::kWatching;
    valid_at_ns_ = at_ns;
    return;
  }
  if (phase_ != Phase::kWatching || at_ns - valid_at_ns_ < rules_.lost_after.count()) return;
  const bool rests = at_ns < rests_until_ns_;
  phase_ = rests ? Phase::kBlind : Phase::kLost;
  skipped_ += rests ? 1 : 0;
  if (!rests) rests_until_ns_ = at_ns + rules_.rest.count();
}

void LossRing::expire() noexcept {
  if (phase_ == Phase::kLost) phase_ = Phase::kReady;
}

void LossRing::reset() {
  slots_ = {};
  first_ = count_ = frame_bytes_ = 0;
  phase_ = Phase::kBlind;
  rests_until_ns_ = 0;
}

void LossRing::release() noexcept {
  first_ = count_ = 0;
  phase_ = Phase::kBlind;
}

}  // namespace ninedot
