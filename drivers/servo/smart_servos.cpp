#include "drivers/servo/smart_servos.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "base/contract.h"
#include "drivers/posix/late_device.h"
#include "drivers/posix/open_advice.h"

namespace ninedot {
namespace {

// Goals are sent without an answer; what a servo holds is looked at with each question where it is. So many looks may
// find an old one before the servo counts as lost: noise takes one or two.
constexpr int kMaxUnheardGoals = 10;

constexpr const char *kSilent = "a servo does not answer", *kAlarm = "a servo reports an error",
                     *kForgets = "a servo does not hold what was written";

SerialLine open_or_refuse(const std::string& device, int baud) {
  auto line = SerialLine::open(device, baud);
  if (line) return *std::move(line);
  const int error = line.error().os_errno;
  std::string advice = open_advice(device, error);
  if (error == ENOTTY) advice = device + ": this is no serial port; correct the device of [pan_tilt]";
  if (error == EINVAL)
    advice = fmt::format("{}: this serial port has no {} baud; set another rate, in the servos as well", device, baud);
  if (error == ENOENT || error == ENXIO || error == ENODEV)
    advice = device + ": there is no such serial port; connect the adapter, or correct the device of [pan_tilt]";
  refuse_device(advice, error);
}

}  // namespace

void check_servo_port(const std::string& device, int baud) { open_or_refuse(device, baud); }

SmartServos::SmartServos(const SmartServoOptions& options, std::unique_ptr<const ServoDialect> dialect)
    : options_(options), dialect_(std::move(dialect)), line_(open_or_refuse(options.device, options.baud), *dialect_) {
  EXPECTS(options.pan_id != options.tilt_id);
  try {
    set_up(options_.pan_id, options_.pan_steps_per_s);
    set_up(options_.tilt_id, options_.tilt_steps_per_s);
  } catch (const StartupError&) {
    if (options_.lone_lets_go) static_cast<void>(release());
    throw;
  }
}

void SmartServos::set_up(int id, double steps_per_s) {
  const ServoTable& table = dialect_->table();
  const auto refuse = [&](const Error& error) {
    throw DeviceAbsent(
        error.text == kAlarm
            ? fmt::format("{}: servo {} reports an error: overheated, overloaded, or its supply is out of range; mend "
                          "that, and switch it off and on",
                          options_.device, id)
            : fmt::format(
                  "{}: servo {} does not answer at {} baud; are its supply, its wires, its ID and its rate right?",
                  options_.device, id, options_.baud));
  };
  if (table.mode_address >= 0) {
    // With the byte behind it: answers to the question of before, whether there is force, may come as late as this, and
    // must not look the same.
    const Result<ServoBytes> found = read(id, table.mode_address, 2);
    if (!found) refuse(found.error());
    if (const int mode = (*found)[0]; mode != table.position_mode)
      throw StartupError(ExitStatus::kWrongUsage,
                         fmt::format("{}: servo {} is in operating mode {}; set mode {}, position control, with its "
                                     "maker's tool",
                                     options_.device, id, mode, table.position_mode));
  } else if (const Result<ServoBytes> torque = read(id, table.torque_address, 1); !torque) {
    refuse(torque.error());
  }
  if (!table.speed_address) return;
  const ServoBytes speed = dialect_->encode_speed(steps_per_s);
  if (const Result<void> done = write(id, *table.speed_address, speed.span()); !done) refuse(done.error());
}

Result<ServoReply> SmartServos::ask(const ServoBytes& packet, int id, std::size_t count) noexcept {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (const Result<void> sent = line_.send(packet); !sent) return tl::unexpected<Error>(sent.error());
    const MonoTime deadline = mono_now() + options_.reply_timeout;
    for (;;) {
      NINEDOT_TRY(const std::optional<ServoReply> reply, line_.receive(deadline));
      if (!reply) break;
      // What is of another size answers something older, or is an echo that came late: its instruction would be taken
      // for the bits of an alarm.
      if (reply->id != id || reply->bytes.size() != count) continue;
      if (reply->alarm) return fail(Errc::kIo, kAlarm);
      return *reply;
    }
  }
  return fail(Errc::kIo, kSilent, ETIMEDOUT);
}

Result<ServoBytes> SmartServos::read(int id, int address, int count) noexcept {
  NINEDOT_TRY(const ServoReply reply,
              ask(dialect_->encode_read(id, address, count), id, static_cast<std::size_t>(count)));
  return reply.bytes;
}

Result<void> SmartServos::write(int id, int address, std::span<const std::uint8_t> bytes) noexcept {
  const ServoBytes packet = dialect_->encode_write({id, bytes}, address);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (const Result<void> sent = line_.send(packet); !sent) return sent;
    // Its answer keeps the line clear for the question. Servos may be set to give none.
    const auto heard = line_.receive(mono_now() + options_.reply_timeout);
    if (!heard) return tl::unexpected<Error>(heard.error());
    NINEDOT_TRY(const ServoBytes now, read(id, address, static_cast<int>(bytes.size())));
    if (std::ranges::equal(now.span(), bytes)) return {};
  }
  return fail(Errc::kIo, kForgets, EIO);
}

Result<bool> SmartServos::collect(const ServoBytes& packet, std::size_t count, Both& both) noexcept {
  bool has_pan = false, has_tilt = false;
  if (const Result<void> sent = line_.send(packet); !sent) return tl::unexpected<Error>(sent.error());
  const MonoTime deadline = mono_now() + 2 * options_.reply_timeout;
  while (!has_pan || !has_tilt) {
    NINEDOT_TRY(const std::optional<ServoReply> reply, line_.receive(deadline));
    if (!reply) return false;
    if (reply->bytes.size() != count) continue;
    if (reply->alarm) return fail(Errc::kIo, kAlarm);
    if (reply->id == options_.pan_id) both.pan = reply->bytes, has_pan = true;
    if (reply->id == options_.tilt_id) both.tilt = reply->bytes, has_tilt = true;
  }
  return true;
}

Result<SmartServos::Both> SmartServos::read_both(int address, int count) noexcept {
  Both both;
  const auto packet = dialect_->encode_read_both(options_.pan_id, options_.tilt_id, address, count);
  if (!packet) {
    NINEDOT_TRY(both.pan, read(options_.pan_id, address, count));
    NINEDOT_TRY(both.tilt, read(options_.tilt_id, address, count));
    return both;
  }
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    NINEDOT_TRY(const bool whole, collect(*packet, static_cast<std::size_t>(count), both));
    if (whole) return both;
  }
  return fail(Errc::kIo, kSilent, ETIMEDOUT);
}

Result<void> SmartServos::set_torque(int id, bool on) noexcept {
  const std::array<std::uint8_t, 1> value{static_cast<std::uint8_t>(on ? 1 : 0)};
  return write(id, dialect_->table().torque_address, value);
}

Result<void> SmartServos::send_goals() noexcept {
  const ServoBytes pan = dialect_->encode_goal(pan_goal_, options_.pan_steps_per_s);
  const ServoBytes tilt = dialect_->encode_goal(tilt_goal_, options_.tilt_steps_per_s);
  return line_.send(dialect_->encode_write_both({options_.pan_id, pan.span()}, {options_.tilt_id, tilt.span()},
                                                dialect_->table().goal_address));
}

Result<void> SmartServos::drive(const ServoTargets& steps) noexcept {
  const auto whole = [this](double position) {
    return static_cast<int>(std::lround(std::clamp<double>(position, 0, dialect_->table().max_position)));
  };
  pan_goal_ = whole(steps.pan);
  tilt_goal_ = whole(steps.tilt);
  unheard_goals_ = 0;
  // Before the force: a servo that takes it first would go to its old goal. One that takes a goal under force only gets
  // it again below.
  if (Result<void> done = send_goals(); !done || is_driven_) return done;
  if (Result<void> done = set_torque(options_.pan_id, true); !done) return done;
  if (Result<void> done = set_torque(options_.tilt_id, true); !done) return done;
  is_driven_ = true;
  torque_at_ = mono_now() + kTorqueInterval;
  return send_goals();
}

Result<void> SmartServos::release() noexcept {
  is_driven_ = false;
  Result<void> pan = set_torque(options_.pan_id, false), tilt = set_torque(options_.tilt_id, false);
  return pan ? tilt : pan;
}

Result<void> SmartServos::check_torque() noexcept {
  for (const int id : {options_.pan_id, options_.tilt_id}) {
    NINEDOT_TRY(const ServoBytes torque, read(id, dialect_->table().torque_address, 1));
    if (torque[0] != 1) return fail(Errc::kIo, "a servo is without force: did its supply drop", EIO);
  }
  return {};
}

Result<ServoReading> SmartServos::look() noexcept {
  const ServoTable& table = dialect_->table();
  if (is_driven_ && mono_now() >= torque_at_) {
    torque_at_ = mono_now() + kTorqueInterval;
    if (const Result<void> done = check_torque(); !done) return tl::unexpected<Error>(done.error());
  }
  NINEDOT_TRY(const Both both, read_both(table.state_address, table.state_size));
  const ServoState pan = dialect_->decode_state(both.pan.span()), tilt = dialect_->decode_state(both.tilt.span());
  const bool heard = !is_driven_ || (pan.goal == pan_goal_ && tilt.goal == tilt_goal_);
  unheard_goals_ = heard ? 0 : unheard_goals_ + 1;
  if (unheard_goals_ > kMaxUnheardGoals) return fail(Errc::kIo, "a servo does not take its goal", EIO);
  if (!heard)
    if (const Result<void> sent = send_goals(); !sent) return tl::unexpected<Error>(sent.error());
  ServoReading reading;
  reading.position = {static_cast<double>(pan.position), static_cast<double>(tilt.position)};
  reading.health.load_percent = std::max(pan.load_percent, tilt.load_percent);
  reading.health.supply_V = std::min(pan.supply_V, tilt.supply_V);
  reading.health.temperature_degC = std::max(pan.temperature_degC, tilt.temperature_degC);
  return reading;
}

}  // namespace ninedot
