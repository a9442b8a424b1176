#include "drivers/servo/gpio_pan_tilt.h"

#include <pthread.h>
#include <sched.h>

#include <cerrno>
#include <ctime>
#include <latch>

#include "base/contract.h"
#include "drivers/servo/sysfs_pwm.h"

namespace ninedot {
namespace {

void sleep_until(MonoTime time) noexcept {
  const std::int64_t ns = to_ns(time);
  const timespec at{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
  }
}

Result<void> ask_for_priority(int priority) noexcept {
  if (priority == 0) return {};
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  if (error != 0) return fail(Errc::kIo, "real-time priority is refused", error);
  return {};
}

}  // namespace

GpioPanTilt::GpioPanTilt(std::unique_ptr<DigitalOutput> pan, std::unique_ptr<DigitalOutput> tilt,
                         const GpioPanTiltOptions& options, const ServoAxes& axes, const HeadAngles& at)
    : pan_line_(std::move(pan)), tilt_line_(std::move(tilt)), options_(options), axes_(axes) {
  EXPECTS(options.period > std::chrono::milliseconds(4));
  move_to(at);
  std::latch entered(1);
  thread_ = std::jthread([this, &entered](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "servo pulses");
    realtime_ = ask_for_priority(options_.realtime_priority);
    entered.count_down();
    run(stop);
  });
  entered.wait();  // realtime() has its answer now
}

GpioPanTilt::~GpioPanTilt() {
  thread_.request_stop();
  thread_.join();
}

void GpioPanTilt::move_to(const HeadAngles& angles) noexcept {
  const ServoAxis::Output pan = axes_.pan.output_at(angles.pan_rad), tilt = axes_.tilt.output_at(angles.tilt_rad);
  pan_ns_.store(pulse_from_us(pan.value).count(), std::memory_order_relaxed);
  tilt_ns_.store(pulse_from_us(tilt.value).count(), std::memory_order_relaxed);
  state_.angles = {axes_.pan.angle_at(pan.value), axes_.tilt.angle_at(tilt.value)};
  state_.limited = pan.limited || tilt.limited;
}

HeadState GpioPanTilt::state() const noexcept {
  HeadState state = state_;
  state.failed = failed_.load(std::memory_order_relaxed);
  state.pulse_error_p99 = errors_.p99();
  state.pulse_error_max = errors_.max();
  return state;
}

bool GpioPanTilt::try_pulse(DigitalOutput& line, MonoTime at, std::chrono::nanoseconds width) noexcept {
  sleep_until(at);
  const bool is_up = line.set(true).has_value();
  const MonoTime risen = mono_now();
  // Counted from the true rise: its lateness shifts the pulse and does not change its width.
  sleep_until(risen + width);
  const bool is_down = line.set(false).has_value();
  errors_.add(mono_now() - risen - width);
  return is_up && is_down;
}

void GpioPanTilt::run(const std::stop_token& stop) noexcept {
  MonoTime begin = mono_now();
  while (!stop.stop_requested()) {
    const std::chrono::nanoseconds pan(pan_ns_.load(std::memory_order_relaxed));
    const std::chrono::nanoseconds tilt(tilt_ns_.load(std::memory_order_relaxed));
    const bool pan_done = try_pulse(*pan_line_, begin, pan);
    const bool tilt_done = try_pulse(*tilt_line_, begin + options_.period / 2, tilt);
    failed_.store(!pan_done || !tilt_done, std::memory_order_relaxed);
    begin += options_.period;
    // After a pause of the whole machine the pulses lost are not made up for.
    if (const MonoTime now = mono_now(); now > begin + options_.period) begin = now;
  }
}

}  // namespace ninedot
