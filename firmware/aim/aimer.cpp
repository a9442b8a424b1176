// A sight becomes a point in the head's base, by where the head stood when it was exposed; the motion of that point is
// followed there and foretold to the time at which a command of now will have been carried out. The angles that bring
// it to the middle then are the goal, their change is the feed-forward; ramps keep to slew and acceleration.
#include "aim/aimer.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// A longer pause between two steps must not become a jump afterwards. Five commands at 50 Hz.
constexpr std::chrono::duration<double> kLongestStep{0.1};
// The frame time at which `gain` is meant, that of the usual camera.
constexpr double kGainFrame_s = 1 / 35.0;
// A memory as long as the loop's whole delay times this keeps the loop stable while the head's true delay is anything
// between none and twice what is configured: tests/aim/loop_margins_test.cpp.
constexpr double kMemoryPerDelay = 1.0;
// A command holds until the next one, on average for half of the time between them.
constexpr std::chrono::nanoseconds kHeldFor = Sweep::kTick / 2;
constexpr auto kRateOver = 10ms;  // the goal's rate is its change over this time
// 1-sigma of when a head is where, its servos' pulses being 20 ms apart; and of where it is when it stands.
constexpr double kTimeSigma_s = 0.005, kPlaceSigma_rad = 0.15 * kRadPerDeg;
// Of the rate itself: an even turn shifts all sights alike, its change is what looks like a motion of the landmark. In
// between by bench_aiming: 0 overshoots a step by 11 %, 1 learns nothing of a robot that passes at 3 m/s.
constexpr double kOfRate = 0.3;
constexpr auto kTurnOver = 20ms;  // the time over which the head's rate is taken
constexpr double kCentred_rad = 3 * kRadPerDeg, kStrayed_rad = 6 * kRadPerDeg;

bool is_axis(const AimAxis& axis) noexcept {
  return axis.min_rad < axis.max_rad && axis.slew_rad_per_s > 0 && axis.acceleration_rad_per_s2 > 0;
}

double braked_rad(const AxisRamp& ramp, const AimAxis& axis) noexcept {
  const double rate = ramp.rate_rad_per_s();
  const double way_rad = rate * std::abs(rate) / (2 * axis.acceleration_rad_per_s2);
  return std::clamp(ramp.angle_rad() + way_rad, axis.min_rad, axis.max_rad);
}

/// How long the filter remembers, for a gain at 35 Hz and the loop's delay.
std::chrono::duration<double> memory_for(double gain, std::chrono::duration<double> delay) noexcept {
  const double by_gain_s = gain < 1 ? -2 * kGainFrame_s / std::log(1 - gain) : 0;
  return std::chrono::duration<double>(std::max(by_gain_s, kMemoryPerDelay * delay.count()));
}

}  // namespace

Aimer::Aimer(const CameraModel& camera, const AimOptions& options, const HeadAngles& head) noexcept
    : options_(options),
      kinematics_(camera, options.body),
      chooser_(options),
      sweep_(options, kinematics_.half_width_rad(), kinematics_.half_height_rad()),
      track_(head),
      pan_(head.pan_rad),
      tilt_(head.tilt_rad),
      pan_standing_(options.dead_band_rad),
      tilt_standing_(options.dead_band_rad),
      stay_(options.neutral) {
  EXPECTS(is_axis(options.pan) && is_axis(options.tilt));
  EXPECTS(options.gain > 0 && options.gain <= 1 && options.dead_band_rad >= 0);
  EXPECTS(options.head_delay >= 0s && options.coast >= 0s && options.park_after >= 0s);
}

void Aimer::take_sight(MonoTime now, const AimSight& sight) noexcept {
  const Eigen::Vector3d point_m = kinematics_.in_base(sight.landmark_camera_m, track_.at(sight.exposed_at));
  const bool is_known = motion_.is_known() && sight.exposed_at - motion_.seen_at() < options_.coast + kNoFrame;
  // A loop that looks seldom is as slow as one that hears late.
  const std::chrono::duration<double> between =
      is_known ? std::min<std::chrono::nanoseconds>(sight.exposed_at - motion_.seen_at(), kNoFrame) : 0ns;
  if (!is_known) motion_.reset();
  if (is_known && sight.id != followed_id_) motion_.change_to(sight.exposed_at, point_m);
  motion_.add(sight.exposed_at, point_m,
              memory_for(options_.gain, now - sight.exposed_at + options_.head_delay + between),
              trust_at(sight.exposed_at));
  followed_id_ = sight.id;
  off_centre_rad_ = kinematics_.off_centre_rad(sight.landmark_camera_m);
  saw_at_ = now;
  active_at_ = now;
}

/// Where the head stood is known by the time, and that to some milliseconds only: what a turning head sees is off by as
/// much, and where its turn has changed since the sight before, that must not be taken for a motion of the landmark.
double Aimer::trust_at(MonoTime exposed_at) const noexcept {
  const auto rate = [this](MonoTime time) -> Eigen::Vector2d {
    const HeadAngles before = track_.at(time - kTurnOver / 2), after = track_.at(time + kTurnOver / 2);
    return Eigen::Vector2d(after.pan_rad - before.pan_rad, after.tilt_rad - before.tilt_rad) /
           std::chrono::duration<double>(kTurnOver).count();
  };
  const Eigen::Vector2d now = rate(exposed_at);
  const double change_rad_s = std::hypot((now - rate(motion_.seen_at())).norm(), kOfRate * now.norm());
  const double ratio = change_rad_s * kTimeSigma_s / kPlaceSigma_rad;
  return 1 / (1 + ratio * ratio);
}

AimEvents Aimer::events(MonoTime now, bool held, bool saw, const AimFrame& frame,
                        const AimOrder& order) const noexcept {
  const bool follows = order.follow && !order.park;
  const bool idles = follows && options_.park_after > 0s && now - active_at_ >= options_.park_after;
  const bool lost = follows && !(saw_at_ && now - *saw_at_ < options_.coast);
  const bool searches = options_.search && (saw_at_ || options_.search_at_start);
  AimEvents events;
  events.set(AimEvent::kHeld, held || (!order.follow && !order.park));
  events.set(AimEvent::kParked, order.park || idles);
  events.set(AimEvent::kSeen, saw);
  events.set(AimEvent::kCentred, saw && off_centre_rad_ < kCentred_rad);
  events.set(AimEvent::kStrayed, saw && off_centre_rad_ > kStrayed_rad);
  events.set(AimEvent::kMissed, !saw && (frame.is_new || !saw_at_ || now - *saw_at_ >= kNoFrame));
  events.set(AimEvent::kSought, lost && searches);
  events.set(AimEvent::kGivenUp, lost && !searches);
  return events;
}

void Aimer::enter(AimState state) noexcept {
  if (state == state_) return;
  if (state == AimState::kSearch) {
    HeadAngles drift;
    if (motion_.is_known()) {
      const HeadAngles then = kinematics_.towards(motion_.at(motion_.seen_at()), command());
      const HeadAngles after = kinematics_.towards(motion_.at(motion_.seen_at() + kRateOver), then);
      const double s = std::chrono::duration<double>(kRateOver).count();
      drift = {(after.pan_rad - then.pan_rad) / s, (after.tilt_rad - then.tilt_rad) / s};
    }
    sweep_.begin(braked(), drift);
  }
  const bool follows = state == AimState::kAcquire || state == AimState::kTrack || state == AimState::kCoast;
  if (!follows) {
    pan_standing_.leave();
    tilt_standing_.leave();
  }
  state_ = state;
}

HeadAngles Aimer::braked() const noexcept { return {braked_rad(pan_, options_.pan), braked_rad(tilt_, options_.tilt)}; }

bool Aimer::is_standing_at(const HeadAngles& angles) const noexcept {
  return pan_.angle_rad() == angles.pan_rad && tilt_.angle_rad() == angles.tilt_rad && pan_.rate_rad_per_s() == 0 &&
         tilt_.rate_rad_per_s() == 0;
}

Aimer::Goal Aimer::still_at(const HeadAngles& angles) const noexcept {
  Goal goal;
  goal.pan.angle_rad = std::clamp(angles.pan_rad, options_.pan.min_rad, options_.pan.max_rad);
  goal.tilt.angle_rad = std::clamp(angles.tilt_rad, options_.tilt.min_rad, options_.tilt.max_rad);
  goal.limited = goal.pan.angle_rad != angles.pan_rad || goal.tilt.angle_rad != angles.tilt_rad;
  return goal;
}

Aimer::Goal Aimer::followed(MonoTime now) noexcept {
  const MonoTime then = now + options_.head_delay + kHeldFor;
  const HeadAngles wanted = kinematics_.towards(motion_.at(then), command());
  const HeadAngles after = kinematics_.towards(motion_.at(then + kRateOver), wanted);
  const double s = std::chrono::duration<double>(kRateOver).count();
  Goal goal = still_at(wanted);
  if (goal.pan.angle_rad == wanted.pan_rad) goal.pan.rate_rad_per_s = (after.pan_rad - wanted.pan_rad) / s;
  if (goal.tilt.angle_rad == wanted.tilt_rad) goal.tilt.rate_rad_per_s = (after.tilt_rad - wanted.tilt_rad) / s;
  goal.pan = pan_standing_.step(now, goal.pan, pan_);
  goal.tilt = tilt_standing_.step(now, goal.tilt, tilt_);
  return goal;
}

Aimer::Goal Aimer::swept() noexcept {
  // Rounding, or a way-point at which the head already is: at most one is passed in a step beside the one it was at.
  for (int i = 0; i < 2 && is_standing_at(sweep_.way_point()); ++i) sweep_.reached();
  return still_at(sweep_.way_point());
}

Aimer::Goal Aimer::goal_of(MonoTime now, const AimOrder& order) noexcept {
  switch (state_) {
    case AimState::kAcquire:
    case AimState::kTrack:
    case AimState::kCoast:
      return followed(now);
    case AimState::kSearch:
      return swept();
    case AimState::kPark:
      return still_at(options_.park);
    case AimState::kHold:
    case AimState::kNone:
      break;
  }
  return still_at(order.follow ? stay_ : order.set_point);
}

AimStep Aimer::step(MonoTime now, const HeadState& head, const AimFrame& frame, const AimOrder& order,
                    bool inhibited) noexcept {
  track_.add(head.measured ? now : now + options_.head_delay, head.angles);
  const bool is_first = stepped_at_ == MonoTime{};
  const double step_s =
      is_first ? 0 : std::clamp(std::chrono::duration<double>(now - stepped_at_), {}, kLongestStep).count();
  stepped_at_ = now;
  if (is_first || order != order_) active_at_ = now;
  order_ = order;

  const AimSight* const sight = frame.is_new ? chooser_.choose(frame.sights) : nullptr;
  if (sight != nullptr) take_sight(now, *sight);
  enter(next_aim_state(state_, events(now, inhibited || head.absent, sight != nullptr, frame, order)));

  // One that is not there, or does not answer, sets out from where it is when it is back.
  if (inhibited || head.absent || (head.measured && head.failed)) {
    pan_.stand(head.angles.pan_rad);
    tilt_.stand(head.angles.tilt_rad);
    return {state_, command(), false, false};
  }
  const Goal goal = goal_of(now, order);
  const bool searches = state_ == AimState::kSearch;
  pan_.advance(goal.pan, searches ? sweep_.pan() : options_.pan, step_s);
  tilt_.advance(goal.tilt, searches ? sweep_.tilt() : options_.tilt, step_s);
  const bool holds_without_order = state_ == AimState::kHold && order.follow;
  if (!holds_without_order) stay_ = braked();
  return {state_, command(), goal.limited, is_standing_at({goal.pan.angle_rad, goal.tilt.angle_rad})};
}

}  // namespace ninedot
