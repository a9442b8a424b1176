#include "aim/arrival.h"

#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

bool is_near(const HeadAngles& a, const HeadAngles& b, double tolerance_rad) noexcept {
  return std::abs(a.pan_rad - b.pan_rad) <= tolerance_rad && std::abs(a.tilt_rad - b.tilt_rad) <= tolerance_rad;
}

}  // namespace

Arrival::Arrival(const AimOptions& options) noexcept
    : options_(options), tolerance_rad_(std::max(options.dead_band_rad, kResolution_rad)) {}

void Arrival::begin(MonoTime now, const AimOrder& order, const ArrivalSight& sight) noexcept {
  number_ = order.number;
  progress_ = order.number == 0 ? OrderProgress::kNone : OrderProgress::kRunning;
  const double way_s =
      std::max(std::abs(order.set_point.pan_rad - sight.head.pan_rad) / options_.pan.slew_rad_per_s,
               std::abs(order.set_point.tilt_rad - sight.head.tilt_rad) / options_.tilt.slew_rad_per_s);
  due_ =
      now + kGrace + std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(1.25 * way_s));
  still_since_ = working_at_ = now;
  still_at_ = sight.head;
}

OrderProgress Arrival::judge(MonoTime now, const AimOrder& order, const ArrivalSight& sight) const noexcept {
  if (sight.inhibited || now - working_at_ >= kSettled) return OrderProgress::kFailed;
  if (sight.failed) return OrderProgress::kRunning;
  if (order.follow) return OrderProgress::kDone;
  const bool there = is_near(sight.head, order.set_point, tolerance_rad_);
  if (sight.at_goal && there && now - still_since_ >= kStanding) return OrderProgress::kDone;
  if (sight.at_goal && sight.limited && !there && now - still_since_ >= kSettled) return OrderProgress::kFailed;
  return now >= due_ ? OrderProgress::kFailed : OrderProgress::kRunning;
}

OrderProgress Arrival::step(MonoTime now, const AimOrder& order, const ArrivalSight& sight) noexcept {
  if (order.number != number_) begin(now, order, sight);
  if (!is_near(sight.head, still_at_, kResolution_rad) || !sight.at_goal) {
    still_at_ = sight.head;
    still_since_ = now;
  }
  if (!sight.failed) working_at_ = now;
  if (progress_ == OrderProgress::kRunning) progress_ = judge(now, order, sight);
  return progress_;
}

}  // namespace ninedot
