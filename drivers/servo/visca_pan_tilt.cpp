/// The caller leaves its order in one atomic word; the thread hands it to the dialogue, sends what the dialogue wants
/// sent, and sleeps in poll() until bytes come, an order comes, or the dialogue has something to do.
#include "drivers/servo/visca_pan_tilt.h"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "base/contract.h"
#include "drivers/posix/late_device.h"
#include "drivers/posix/open_advice.h"
#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

constexpr int kBaud = 9600;  // of VISCA
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// One word, so that the frame loop and the thread never wait for each other, whatever their priorities.
std::uint64_t pack(const ViscaOrder& order) noexcept {
  return std::uint64_t{order.sequence} << 40U | std::uint64_t{static_cast<std::uint8_t>(order.kind)} << 32U |
         std::uint64_t{static_cast<std::uint16_t>(order.position.pan_steps)} << 16U |
         static_cast<std::uint16_t>(order.position.tilt_steps);
}

ViscaOrder unpack(std::uint64_t word) noexcept {
  return {static_cast<ViscaOrder::Kind>(word >> 32U & 0xFFU),
          {static_cast<std::int16_t>(word >> 16U & 0xFFFFU), static_cast<std::int16_t>(word & 0xFFFFU)},
          static_cast<std::uint32_t>(word >> 40U)};
}

std::int16_t whole_steps(double steps) noexcept {
  using Limits = std::numeric_limits<std::int16_t>;
  return static_cast<std::int16_t>(std::lround(std::clamp<double>(steps, Limits::min(), Limits::max())));
}

void expect(bool right, const std::string& line) {
  if (!right) throw StartupError(ExitStatus::kWrongUsage, line);
}

ViscaOptions checked(const ViscaOptions& options) {
  expect(!options.device.empty(), "a VISCA head needs the name of its serial port: set the device of [pan_tilt]");
  expect(options.address >= kMinViscaAddress && options.address <= kMaxViscaAddress,
         fmt::format("a VISCA camera's address is 1 to 7, not {}", options.address));
  expect(options.pan_speed >= 1 && options.pan_speed <= kMaxViscaPanSpeed,
         fmt::format("a VISCA camera's pan speed is 1 to {}, not {}", kMaxViscaPanSpeed, options.pan_speed));
  expect(options.tilt_speed >= 1 && options.tilt_speed <= kMaxViscaTiltSpeed,
         fmt::format("a VISCA camera's tilt speed is 1 to {}, not {}", kMaxViscaTiltSpeed, options.tilt_speed));
  if (options.zoom)
    expect(*options.zoom >= 0 && *options.zoom <= kEviD31MaxZoom,
           fmt::format("this camera's zoom is 0 to {}, not {}", kEviD31MaxZoom, *options.zoom));
  return options;
}

std::string cannot_open(const std::string& device, int error) {
  if (error == ENOTTY) return device + ": this is no serial port; correct the device of [pan_tilt]";
  if (error == EINVAL) return device + ": this serial port has no 9600 baud; take another one";
  if (error == ENOENT || error == ENXIO || error == ENODEV)
    return device + ": there is no such serial port; connect the adapter, or correct the device of [pan_tilt]";
  return open_advice(device, error);
}

std::string cannot_start(const ViscaOptions& options, const ViscaDialogue& dialogue, ViscaProblem problem) {
  switch (problem) {
    case ViscaProblem::kUnreadable:
      return fmt::format("{}: what arrives is not VISCA at 9600 baud; set the camera to 9600 baud and check the cable",
                         options.device);
    case ViscaProblem::kNoSuchCamera: {
      const int last = dialogue.cameras().value_or(0);
      if (last == 0)
        return fmt::format("{}: the line brings back what it is sent, without a camera in it; check the cable",
                           options.device);
      return fmt::format(
          "{}: the chain ends at address {}, there is no camera {}; correct the address of [pan_tilt], or connect and "
          "switch on what is missing",
          options.device, last, options.address);
    }
    case ViscaProblem::kRefused:
      return fmt::format("{}: camera {} refuses to answer; is it in standby? switch it on", options.device,
                         options.address);
    case ViscaProblem::kZoom:
      return fmt::format("{}: the lens stands at zoom {} and does not reach {}; switch the camera off and on",
                         options.device, dialogue.zoom().value_or(-1), options.zoom.value_or(-1));
    case ViscaProblem::kNone:
    case ViscaProblem::kSilent:
      break;
  }
  return fmt::format("{}: no camera answers at address {}; is it switched on, and the cable a crossed one to VISCA IN?",
                     options.device, options.address);
}

SerialLine open_or_refuse(const std::string& device) {
  auto tty = SerialLine::open(device, kBaud);
  if (!tty) refuse_device(cannot_open(device, tty.error().os_errno), tty.error().os_errno);
  return *std::move(tty);
}

}  // namespace

void check_visca_port(const std::string& device) { open_or_refuse(device); }

ViscaPanTilt::ViscaPanTilt(const ViscaOptions& options, const ServoAxes& axes)
    : options_(checked(options)),
      axes_(axes),
      order_(0),
      dialogue_(options_),
      backoff_(options_.first_reopen_wait, options_.longest_reopen_wait),
      ordered_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!ordered_) throw StartupError(ExitStatus::kWorkFailed, "no more descriptors: raise the limit of open files");
  start();
  thread_ = std::thread([this]() noexcept { run(); });
}

ViscaPanTilt::~ViscaPanTilt() {
  stop_.ring();
  thread_.join();
}

void ViscaPanTilt::start() {
  tty_.emplace(open_or_refuse(options_.device));
  dialogue_.begin(mono_now());
  if (talk(true) == LineState::kGood) return;
  throw DeviceAbsent(cannot_start(options_, dialogue_, dialogue_.problem(mono_now())), ExitStatus::kWorkFailed);
}

void ViscaPanTilt::leave_order(ViscaOrder::Kind kind, const ViscaPosition& position) noexcept {
  const ViscaOrder last = unpack(order_.load(std::memory_order_relaxed));
  // A target said again at every frame is no news; a stop always is.
  if (kind == ViscaOrder::Kind::kMove && last.kind == kind && last.position == position) return;
  order_.store(pack({kind, position, (last.sequence + 1) & 0xFFFFFFU}), std::memory_order_release);
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(ordered_.get(), &one, sizeof one);
}

void ViscaPanTilt::move_to(const HeadAngles& angles) noexcept {
  EXPECTS(std::isfinite(angles.pan_rad) && std::isfinite(angles.tilt_rad));
  const ServoAxis::Output pan = axes_.pan.output_at(angles.pan_rad), tilt = axes_.tilt.output_at(angles.tilt_rad);
  limited_ = pan.limited || tilt.limited;
  leave_order(ViscaOrder::Kind::kMove, {whole_steps(pan.value), whole_steps(tilt.value)});
}

void ViscaPanTilt::stop() noexcept { leave_order(ViscaOrder::Kind::kStop, {}); }

HeadState ViscaPanTilt::state() const noexcept {
  const std::uint32_t word = position_.load(std::memory_order_acquire);
  HeadState state;
  state.measured = true;
  state.angles.pan_rad = axes_.pan.angle_at(static_cast<std::int16_t>(word >> 16U));
  state.angles.tilt_rad = axes_.tilt.angle_at(static_cast<std::int16_t>(word & 0xFFFFU));
  state.limited = limited_;
  state.failed = failed_.load(std::memory_order_acquire);
  state.losses = static_cast<std::uint32_t>(losses());
  state.zoom = zoom_stand_.take();
  return state;
}

std::optional<int> ViscaPanTilt::zoom() const noexcept {
  const int zoom = zoom_.load(std::memory_order_relaxed);
  return zoom < 0 ? std::nullopt : std::optional(zoom);
}

void ViscaPanTilt::publish() noexcept {
  const ViscaPosition& position = dialogue_.position();
  if (dialogue_.is_ready()) {
    position_.store(std::uint32_t{static_cast<std::uint16_t>(position.pan_steps)} << 16U |
                        static_cast<std::uint16_t>(position.tilt_steps),
                    std::memory_order_release);
    zoom_.store(dialogue_.zoom().value_or(-1), std::memory_order_relaxed);
  }
  zoom_stand_.put(dialogue_.zoom_stand());
  failed_.store(!dialogue_.is_ready() || dialogue_.is_refused(), std::memory_order_release);
}

void ViscaPanTilt::run() noexcept {
  ::pthread_setname_np(::pthread_self(), "visca");
  for (;;) {
    if (talk(false) == LineState::kStopping) return;
    failed_.store(true, std::memory_order_release);
    zoom_stand_.put(std::nullopt);
    losses_.fetch_add(1, std::memory_order_relaxed);
    tty_.reset();
    if (!reopen()) return;
  }
}

bool ViscaPanTilt::reopen() noexcept {
  // An order that comes meanwhile is not forgotten; nobody is there to hear it.
  while (!is_rung_within(stop_, backoff_.next())) {
    auto tty = SerialLine::open(options_.device, kBaud);
    if (!tty) continue;
    tty_.emplace(*std::move(tty));
    dialogue_.begin(mono_now());
    return true;
  }
  return false;
}

ViscaPanTilt::LineState ViscaPanTilt::talk(bool until_ready) noexcept {
  for (;;) {
    dialogue_.order(unpack(order_.load(std::memory_order_acquire)));
    const MonoTime now = mono_now();
    if (const auto packet = dialogue_.next_packet(now); packet && !tty_->try_send(packet->bytes()))
      return LineState::kLost;
    if (dialogue_.is_lost(now)) return LineState::kLost;
    publish();
    if (dialogue_.is_ready()) {
      backoff_.reset();
      if (until_ready) return LineState::kGood;
    }
    if (const LineState state = wait_and_receive(); state != LineState::kGood) return state;
  }
}

ViscaPanTilt::LineState ViscaPanTilt::wait_and_receive() noexcept {
  std::array<pollfd, 3> polled = {{{stop_.get(), POLLIN, 0}, {ordered_.get(), POLLIN, 0}, {tty_->get(), POLLIN, 0}}};
  if (poll_until(polled, dialogue_.wake_at()) <= 0) return LineState::kGood;
  if (polled[0].revents != 0) return LineState::kStopping;
  if (polled[1].revents != 0) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(ordered_.get(), &count, sizeof count);
  }
  if ((polled[2].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return LineState::kLost;
  if (polled[2].revents == 0) return LineState::kGood;
  std::array<std::uint8_t, 256> bytes;
  const auto got = tty_->receive(bytes);
  if (!got) return LineState::kLost;
  dialogue_.receive(std::span(bytes).first(*got), mono_now());
  return LineState::kGood;
}

}  // namespace ninedot
