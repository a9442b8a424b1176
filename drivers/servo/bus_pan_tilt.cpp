#include "drivers/servo/bus_pan_tilt.h"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>

#include <array>
#include <cstring>

#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

// A bus that has failed twice in the last moment is not worth a longer end.
constexpr int kReleaseAttempts = 3;

std::string line_about(const Error& error) {
  return error.os_errno == 0 ? error.text : fmt::format("{}: {}", error.text, std::strerror(error.os_errno));
}

}  // namespace

BusPanTilt::BusPanTilt(Open open, const BusPanTiltOptions& options, const ServoAxes& axes, const HeadAngles& at)
    : open_(std::move(open)), options_(options), axes_(axes), backoff_(options.reopening) {
  bus_ = open_();
  Result<void> done = look();
  if (done && !tells_position_) {
    const RunningTargets running = bus_->running();
    ordered_.targets = {running.pan.value_or(axes_.pan.output_at(at.pan_rad).value),
                        running.tilt.value_or(axes_.tilt.output_at(at.tilt_rad).value)};
    leave(Order::Kind::kDrive);
    done = obey(orders_.take());
  }
  if (!done) {
    let_go();
    throw DeviceAbsent(line_about(done.error()));
  }
  publish();
  thread_ = std::thread([this]() noexcept { run(); });
}

BusPanTilt::~BusPanTilt() {
  if (!thread_.joinable()) return;
  ends_.store(true, std::memory_order_relaxed);
  stop_.ring();
  thread_.join();
  // One that was lost just now may be there again.
  if (!bus_ && options_.when_stopped == WhenStopped::kRelease) bus_ = try_open(open_, problem_);
  let_go();
}

void BusPanTilt::let_go() noexcept {
  if (!bus_ || options_.when_stopped == WhenStopped::kHold) return;
  for (int attempt = 0; attempt < kReleaseAttempts && !bus_->release(); ++attempt) {
  }
}

void BusPanTilt::leave(Order::Kind kind) noexcept {
  ordered_.kind = kind;
  ++ordered_.sequence;
  orders_.put(ordered_);
  told_.ring();
}

void BusPanTilt::move_to(const HeadAngles& angles) noexcept {
  const ServoAxis::Output pan = axes_.pan.output_at(angles.pan_rad), tilt = axes_.tilt.output_at(angles.tilt_rad);
  limited_ = pan.limited || tilt.limited;
  const ServoTargets targets{pan.value, tilt.value};
  // The bus has more to do than to hear the same with every frame.
  if (ordered_.kind == Order::Kind::kDrive && ordered_.targets == targets) return;
  ordered_.targets = targets;
  leave(Order::Kind::kDrive);
}

void BusPanTilt::stop() noexcept { leave(Order::Kind::kStop); }

HeadState BusPanTilt::state() const noexcept {
  const Seen& seen = seen_out_.take();
  HeadState state;
  state.angles = {axes_.pan.angle_at(seen.position.pan), axes_.tilt.angle_at(seen.position.tilt)};
  state.measured = seen.tells_position;
  state.limited = limited_;
  state.failed = seen.failed;
  state.losses = seen.losses;
  state.servos = seen.health;
  return state;
}

Result<void> BusPanTilt::obey(const Order& order) noexcept {
  if (order.sequence == done_) return {};
  Result<void> done;
  if (order.kind == Order::Kind::kDrive) {
    done = bus_->drive(order.targets);
    if (done && !tells_position_) seen_.position = order.targets;
  } else if (options_.when_stopped == WhenStopped::kRelease) {
    done = bus_->release();
  } else if (tells_position_) {
    // Its target may lie far ahead.
    done = bus_->drive(seen_.position);
  }
  if (done) done_ = order.sequence;
  return done;
}

Result<void> BusPanTilt::look() noexcept {
  NINEDOT_TRY(const ServoReading reading, bus_->look());
  look_at_ = mono_now() + options_.look_interval;
  tells_position_ = reading.position.has_value();
  if (tells_position_) seen_.position = *reading.position;
  seen_.health = reading.health;
  return {};
}

void BusPanTilt::publish() noexcept {
  seen_.tells_position = tells_position_;
  seen_out_.put(seen_);
}

bool BusPanTilt::reopen() noexcept {
  while (!bus_) {
    if (is_rung_within(stop_, backoff_.next())) return false;
    bus_ = try_open(open_, problem_);
  }
  done_ = 0;
  look_at_ = {};
  return true;
}

void BusPanTilt::run() noexcept {
  ::pthread_setname_np(::pthread_self(), "servo bus");
  while (!ends_.load(std::memory_order_relaxed)) {
    Result<void> done = obey(orders_.take());
    if (done && mono_now() >= look_at_) done = look();
    if (done) {
      seen_.failed = false;
      backoff_.reset();
      publish();
      std::array<pollfd, 2> polled{{{stop_.get(), POLLIN, 0}, {told_.get(), POLLIN, 0}}};
      if (poll_until(polled, look_at_) > 0 && polled[1].revents != 0) told_.answer();
      continue;
    }
    seen_.failed = true;
    ++seen_.losses;
    seen_.health = {};
    publish();
    bus_.reset();
    if (!reopen()) return;
  }
}

}  // namespace ninedot
