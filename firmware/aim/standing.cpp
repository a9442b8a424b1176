#include "aim/standing.h"

#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// A swing of hunting takes a few times the delay of the loop; a head that turned back after longer had a reason.
constexpr auto kSwingTakes = 2s;
// Where the dead band is 0, the first swing's: above what a settled estimate's noise moves the command by.
constexpr double kLeastBand_rad = 0.1 * kRadPerDeg;
// An axis comes to rest this near its goal, so that a place on the edge of the band is none to rest at, and only when
// it has been so near for as long as an estimate takes to settle.
constexpr double kArrived = 0.25;  // of the band
constexpr auto kSettles = 200ms;
// Slower than one dead band in so long, the landmark is taken to stand. Seven frames.
constexpr double kStill_s = 0.2;

}  // namespace

/// A swing ends where the command turns back by more than the dead band; less is noise.
void Standing::watch_for_swings(MonoTime now, const AxisRamp& command) noexcept {
  const double at_rad = command.angle_rad();
  if (!turned_rad_) turned_rad_ = furthest_rad_ = at_rad;
  // Who goes on in one direction follows something.
  if (std::abs(at_rad - *turned_rad_) > kSwing_rad) band_rad_ = own_rad_;
  if ((at_rad - furthest_rad_) * (furthest_rad_ - *turned_rad_) >= 0) {
    furthest_rad_ = at_rad;
    return;
  }
  const double counts_rad = std::max(band_rad_, kLeastBand_rad);
  if (std::abs(at_rad - furthest_rad_) <= counts_rad) return;
  const double swing_rad = std::abs(furthest_rad_ - *turned_rad_);
  if (swing_rad > counts_rad && swing_rad < kSwing_rad && now - turned_at_ < kSwingTakes)
    band_rad_ = std::max(own_rad_, std::min(2 * counts_rad, kWidest_rad));
  turned_rad_ = furthest_rad_;
  furthest_rad_ = at_rad;
  turned_at_ = now;
}

AxisGoal Standing::step(MonoTime now, const AxisGoal& goal, const AxisRamp& command) noexcept {
  watch_for_swings(now, command);
  const double deviation_rad = std::abs(goal.angle_rad - command.angle_rad());
  if (deviation_rad > std::max(kSwing_rad, own_rad_)) band_rad_ = own_rad_;
  const bool is_near = deviation_rad <= kArrived * band_rad_ && std::abs(goal.rate_rad_per_s) * kStill_s <= band_rad_;
  if (!is_near)
    near_since_.reset();
  else if (!near_since_)
    near_since_ = now;
  if (rests_) {
    rests_ = std::abs(goal.angle_rad - rest_rad_) <= band_rad_;
  } else if (near_since_ && now - *near_since_ >= kSettles) {
    rests_ = true;
    rest_rad_ = goal.angle_rad;
  }
  return rests_ ? AxisGoal{rest_rad_, 0} : goal;
}

}  // namespace ninedot
