#include "aim/sweep.h"

#include <algorithm>
#include <cmath>

#include "aim/axis_ramp.h"
#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

// A landmark must be whole in a picture to be found: a fifth of the height is what one at the usual distance takes.
constexpr double kRowShare = 0.8;
// The narrowest lens that rows are made for, a telephoto: it bounds the number of rows.
constexpr double kLeastHeight_rad = 1 * kRadPerDeg;
// Slower, nothing is known of where the landmark went: ten times what a settled estimate errs by.
constexpr double kDrift_rad_per_s = 1 * kRadPerDeg;

// What the command takes to land on a way-point and to be sent to the next one.
constexpr double kAtWayPoint_s = 3 * std::chrono::duration<double>(Sweep::kTick).count();

AimAxis searching(const AimAxis& axis, double rad_per_s) noexcept {
  AimAxis slower = axis;
  slower.slew_rad_per_s = std::min(axis.slew_rad_per_s, rad_per_s);
  return slower;
}

std::chrono::nanoseconds from_s(double s) noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(s));
}

}  // namespace

Sweep::Sweep(const AimOptions& options, double half_width_rad, double half_height_rad) noexcept
    : pan_(searching(options.pan, options.search_rad_per_s)), tilt_(searching(options.tilt, options.search_rad_per_s)) {
  EXPECTS(options.search_rad_per_s > 0 && half_width_rad >= 0);
  const double height_rad = std::max(2 * half_height_rad * kRowShare, kLeastHeight_rad);
  row_count_ = 1 + static_cast<int>(std::ceil((tilt_.max_rad - tilt_.min_rad) / height_rad));
  for (const double pan_rad : {pan_.min_rad, (pan_.min_rad + pan_.max_rad) / 2, pan_.max_rad})
    for (int row = 0; row < row_count_; ++row)
      for (const double side : {-1.0, 1.0})
        for (const double up : {-1.0, 1.0}) {
          begin({pan_rad, row_rad(row)}, {side, up});
          // A place between two rows is half of their distance from either.
          const double hop_s = ramp_time_s((row_rad(1) - row_rad(0)) / 2, tilt_);
          longest_ = std::max(longest_, duration_ + from_s(hop_s));
          // Anew, from where the first round ended.
          longest_ = std::max(longest_, from_s(duration_s(next_round())));
        }
}

double Sweep::row_rad(int row) const noexcept {
  return tilt_.min_rad + (tilt_.max_rad - tilt_.min_rad) * row / (row_count_ - 1);
}

/// The row that comes at a place in the order, 0 being the first.
int Sweep::row_of(const Plan& plan, int place) const noexcept {
  const int above = row_count_ - 1 - plan.first_row, below = plan.first_row;
  if (plan.up_first) return place <= above ? plan.first_row + place : plan.first_row - (place - above);
  return place <= below ? plan.first_row - place : plan.first_row + (place - below);
}

int Sweep::way_point_count(const Plan& plan) const noexcept {
  return plan.finishes_last ? 2 * row_count_ + 2 : 2 * row_count_ + 1;
}

/// To the first row, along it to one end, then: back to the other end and on with the other rows; or the other rows at
/// once, and last what is left of the first one, from whichever side is nearer.
HeadAngles Sweep::way_point(const Plan& plan, int index) const noexcept {
  const double first_rad = row_rad(plan.first_row);
  if (index == 0) return {plan.from.pan_rad, first_rad};
  if (index == 1) return {end_rad(plan.side), first_rad};
  int after = index - 2;
  double side = plan.side;  // at which it is
  if (!plan.finishes_last) {
    if (after == 0) return {end_rad(-side), first_rad};
    --after;
    side = -side;
  }
  const int place = 1 + after / 2;
  if (place % 2 == 0) side = -side;
  if (place < row_count_) return {end_rad(after % 2 == 0 ? side : -side), row_rad(row_of(plan, place))};
  const bool is_first = after % 2 == 0;
  if (side == plan.side) return {is_first ? plan.from.pan_rad : end_rad(-side), first_rad};
  return {is_first ? end_rad(side) : plan.from.pan_rad, first_rad};
}

double Sweep::duration_s(const Plan& plan) const noexcept {
  double s = 0;
  HeadAngles at = plan.from;
  for (int i = 0; i < way_point_count(plan); ++i) {
    const HeadAngles to = way_point(plan, i);
    s += std::max(ramp_time_s(to.pan_rad - at.pan_rad, pan_), ramp_time_s(to.tilt_rad - at.tilt_rad, tilt_));
    s += kAtWayPoint_s;
    at = to;
  }
  return s;
}

int Sweep::row_near(double tilt_rad) const noexcept {
  const double part =
      (std::clamp(tilt_rad, tilt_.min_rad, tilt_.max_rad) - tilt_.min_rad) / (tilt_.max_rad - tilt_.min_rad);
  return static_cast<int>(std::lround(part * (row_count_ - 1)));
}

Sweep::Plan Sweep::best_plan(const HeadAngles& from, const HeadAngles& drift_rad_per_s, int first_row) const noexcept {
  Plan plan;
  plan.from = {std::clamp(from.pan_rad, pan_.min_rad, pan_.max_rad),
               std::clamp(from.tilt_rad, tilt_.min_rad, tilt_.max_rad)};
  plan.first_row = first_row;
  const bool left_is_nearer = pan_.max_rad - plan.from.pan_rad < plan.from.pan_rad - pan_.min_rad;
  plan.side = left_is_nearer ? 1 : -1;
  if (std::abs(drift_rad_per_s.pan_rad) > kDrift_rad_per_s) plan.side = std::copysign(1.0, drift_rad_per_s.pan_rad);
  const bool knows_up = std::abs(drift_rad_per_s.tilt_rad) > kDrift_rad_per_s;
  Plan best = plan;
  best.up_first = drift_rad_per_s.tilt_rad > 0;
  for (const bool up_first : {true, false})
    for (const bool finishes_last : {false, true}) {
      plan.up_first = up_first;
      plan.finishes_last = finishes_last;
      const bool is_that_way = !knows_up || up_first == (drift_rad_per_s.tilt_rad > 0);
      if (is_that_way && duration_s(plan) < duration_s(best)) best = plan;
    }
  return best;
}

void Sweep::begin(const HeadAngles& from, const HeadAngles& drift_rad_per_s) noexcept {
  start(best_plan(from, drift_rad_per_s, row_near(from.tilt_rad)));
}

void Sweep::start(const Plan& plan) noexcept {
  plan_ = plan;
  duration_ = from_s(duration_s(plan_));
  next_ = 0;
}

Sweep::Plan Sweep::next_round() const noexcept {
  return best_plan(way_point(plan_, way_point_count(plan_) - 1), {}, plan_.first_row);
}

void Sweep::reached() noexcept {
  if (++next_ == way_point_count(plan_)) start(next_round());
}

}  // namespace ninedot
