/// The start goes through the steps in their order; from then on the order of importance is: cancels, a stop, the
/// questions for position and zoom when they are due, a motion.
#include "drivers/servo/visca_dialogue.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr std::uint32_t bit(int socket) noexcept { return 1U << static_cast<unsigned>(socket); }
constexpr std::uint32_t kEverySocket = bit(1) | bit(2);
static_assert(kViscaSockets == 2);

}  // namespace

ViscaDialogue::ViscaDialogue(const ViscaOptions& options) noexcept
    : options_(options), speeds_{options.pan_speed, options.tilt_speed} {
  EXPECTS(options.address >= kMinViscaAddress && options.address <= kMaxViscaAddress);
}

void ViscaDialogue::begin(MonoTime now) noexcept {
  stream_.reset();
  step_ = Step::kAddress;
  awaited_ = Awaited::kNothing;
  poll_at_ = zoom_poll_at_ = command_at_ = now;
  unanswered_since_ = {};
  done_ = order_.kind == ViscaOrder::Kind::kNone;
  sent_ = Command::kNone;
  sockets_ = {};
  to_cancel_ = 0;
  refusals_ = 0;
  refused_ = gave_up_ = heard_bytes_ = heard_packets_ = false;
  answer_ = ViscaProblem::kNone;
  zoom_.reset();
  zoom_answers_.forget();
  cameras_.reset();
}

void ViscaDialogue::order(const ViscaOrder& order) noexcept {
  if (order.sequence == order_.sequence) return;
  order_ = order;
  done_ = order.kind == ViscaOrder::Kind::kNone;
  // Frames come faster than a camera that refuses should be asked.
  if (!refused_) command_at_ = MonoTime::min();
}

bool ViscaDialogue::is_lost(MonoTime now) const noexcept {
  return gave_up_ || std::ranges::any_of(unanswered_since_, [&](const std::optional<MonoTime>& since) {
           return since && now - *since >= options_.answer_timeout;
         });
}

ViscaProblem ViscaDialogue::problem(MonoTime now) const noexcept {
  if (!is_lost(now)) return refused_ ? ViscaProblem::kRefused : ViscaProblem::kNone;
  if (answer_ != ViscaProblem::kNone) return answer_;
  return heard_bytes_ && !heard_packets_ ? ViscaProblem::kUnreadable : ViscaProblem::kSilent;
}

MonoTime ViscaDialogue::wake_at() const noexcept {
  MonoTime at = MonoTime::max();
  for (const std::optional<MonoTime>& since : unanswered_since_)
    if (since) at = std::min(at, *since + options_.answer_timeout);
  if (awaited_ != Awaited::kNothing) return std::min(at, reply_by_);
  if (step_ == Step::kZoomRead || step_ == Step::kReady) at = std::min(at, poll_at_);
  if (step_ == Step::kReady && options_.zoom_interval) at = std::min(at, zoom_poll_at_);
  if (step_ == Step::kReady && has_to_command()) at = std::min(at, command_at_);
  return at;
}

std::optional<ViscaPacket> ViscaDialogue::next_packet(MonoTime now) noexcept {
  if (is_lost(now)) return std::nullopt;
  if (awaited_ != Awaited::kNothing) {
    if (now < reply_by_) return std::nullopt;
    if (awaited_ == Awaited::kCancel) to_cancel_ |= bit(cancelling_);
    awaited_ = Awaited::kNothing;
  }
  return step_ == Step::kReady ? next_when_ready(now) : next_of_start(now);
}

std::optional<ViscaPacket> ViscaDialogue::next_of_start(MonoTime now) noexcept {
  switch (step_) {
    case Step::kAddress:
      return ask(Awaited::kAddress, encode_visca_address_set(), now);
    case Step::kClear:
      return ask(Awaited::kClear, encode_visca_if_clear(), now);
    case Step::kZoomSet:
      return command(Command::kZoom, encode_visca_zoom(options_.address, options_.zoom.value_or(0)), now);
    case Step::kZoomRead:
      if (now < poll_at_) return std::nullopt;
      poll_at_ = now + options_.poll_interval;
      return ask(Awaited::kZoom, encode_visca_zoom_inquiry(options_.address), now);
    case Step::kPosition:
    case Step::kReady:
      break;
  }
  return ask(Awaited::kPosition, encode_visca_position_inquiry(options_.address), now);
}

std::optional<ViscaPacket> ViscaDialogue::next_when_ready(MonoTime now) noexcept {
  if (to_cancel_ != 0) return next_cancel(now);
  const bool may_command = has_to_command() && now >= command_at_;
  if (may_command && order_.kind == ViscaOrder::Kind::kStop) {
    // The drive's stop alone leaves a motion to a position running, or is refused while one runs.
    to_cancel_ = sockets_with(Command::kMove);
    if (to_cancel_ != 0) return next_cancel(now);
    return command(Command::kStop, encode_visca_stop(options_.address, speeds_), now);
  }
  if (now >= poll_at_) {
    // Counted from when it was due: a busy line delays a question, and does not make them rarer.
    poll_at_ = (now - poll_at_ < options_.poll_interval ? poll_at_ : now) + options_.poll_interval;
    return ask(Awaited::kPosition, encode_visca_position_inquiry(options_.address), now);
  }
  if (options_.zoom_interval && now >= zoom_poll_at_) {
    zoom_poll_at_ = now + *options_.zoom_interval;
    return ask(Awaited::kZoom, encode_visca_zoom_inquiry(options_.address), now);
  }
  if (!may_command) return std::nullopt;
  if (cancels_first_) to_cancel_ = sockets_with(Command::kMove);
  if (to_cancel_ == 0 && running() >= kViscaSockets) to_cancel_ = oldest_socket();
  if (to_cancel_ != 0) return next_cancel(now);
  return command(Command::kMove, encode_visca_move(options_.address, speeds_, order_.position), now);
}

std::optional<ViscaPacket> ViscaDialogue::next_cancel(MonoTime now) noexcept {
  cancelling_ = 1;
  while ((to_cancel_ & bit(cancelling_)) == 0) ++cancelling_;
  to_cancel_ &= ~bit(cancelling_);
  return ask(Awaited::kCancel, encode_visca_cancel(options_.address, cancelling_), now);
}

ViscaPacket ViscaDialogue::ask(Awaited awaited, const ViscaPacket& packet, MonoTime now) noexcept {
  awaited_ = awaited;
  reply_by_ = now + options_.reply_timeout;
  std::optional<MonoTime>& since = unanswered_since_[static_cast<std::size_t>(awaited)];
  if (!since) since = now;
  return packet;
}

ViscaPacket ViscaDialogue::command(Command kind, const ViscaPacket& packet, MonoTime now) noexcept {
  sent_ = kind;
  sent_sequence_ = order_.sequence;
  return ask(Awaited::kAck, packet, now);
}

void ViscaDialogue::answered(Awaited awaited) noexcept {
  unanswered_since_[static_cast<std::size_t>(awaited)].reset();
  if (awaited_ == awaited) awaited_ = Awaited::kNothing;
  answer_ = ViscaProblem::kNone;
}

void ViscaDialogue::receive(std::span<const std::uint8_t> bytes, MonoTime now) noexcept {
  for (const std::uint8_t byte : bytes) {
    heard_bytes_ = true;
    const auto packet = stream_.receive(byte);
    if (!packet) continue;
    if (const auto reply = decode_visca_reply(*packet)) take(*reply, now);
  }
}

void ViscaDialogue::take(const ViscaReply& reply, MonoTime now) noexcept {
  using Kind = ViscaReply::Kind;
  const bool is_for_all = reply.address == 0 || reply.kind == Kind::kNetworkChange;
  if (!is_for_all && reply.address != options_.address) return;
  heard_packets_ = true;
  switch (reply.kind) {
    case Kind::kAddressSet:
      if (step_ != Step::kAddress) return;
      cameras_ = reply.cameras;
      // Asked again until the time is over: a camera may be about to start.
      if (reply.cameras < options_.address) {
        answer_ = ViscaProblem::kNoSuchCamera;
        return;
      }
      answered(Awaited::kAddress);
      step_ = Step::kClear;
      return;
    case Kind::kIfClear:
      if (step_ != Step::kClear) return;
      answered(Awaited::kClear);
      step_ = options_.zoom ? Step::kZoomSet : Step::kPosition;
      zoom_by_ = now + options_.zoom_timeout;
      return;
    case Kind::kAck:
      return take_ack(reply.socket, now);
    case Kind::kCompletion:
      sockets_[static_cast<std::size_t>(reply.socket)] = {};
      return;
    case Kind::kPosition:
      position_ = reply.position;
      answered(Awaited::kPosition);
      if (step_ == Step::kPosition) {
        step_ = Step::kReady;
        poll_at_ = now + options_.poll_interval;
      }
      return;
    case Kind::kZoom:
      return take_zoom(reply.zoom, now);
    case Kind::kError:
      return take_fault(reply.fault, reply.socket, now);
    case Kind::kNetworkChange:
      // While addresses are being set it may be the camera's answer to that.
      if (step_ != Step::kAddress && step_ != Step::kClear) begin(now);
      return;
  }
}

void ViscaDialogue::take_ack(int socket, MonoTime now) noexcept {
  if (sent_ == Command::kNone) return;
  // Socket 0 can't be cancelled; it is not kept in mind.
  if (socket != 0) sockets_[static_cast<std::size_t>(socket)] = {sent_, ++next_age_};
  answered(Awaited::kAck);
  refusals_ = 0;
  refused_ = false;
  if (sent_ == Command::kZoom) {
    if (step_ != Step::kZoomSet) return;
    step_ = Step::kZoomRead;
    poll_at_ = now + options_.poll_interval;
  } else if (sent_sequence_ == order_.sequence) {
    done_ = true;
  }
}

void ViscaDialogue::take_zoom(int zoom, MonoTime now) noexcept {
  const bool stands_still = zoom_ == zoom;
  zoom_ = zoom;
  zoom_answers_.add(zoom, now);
  answered(Awaited::kZoom);
  if (step_ != Step::kZoomRead || !options_.zoom) return;
  // A reading on the way counts only when the completion has come, or when it stays the same: a completion may get
  // lost.
  const bool arrived = sockets_with(Command::kZoom) == 0 || stands_still;
  if (arrived && std::abs(zoom - *options_.zoom) <= options_.zoom_tolerance) {
    for (Socket& socket : sockets_)
      if (socket.command == Command::kZoom) socket = {};
    step_ = Step::kPosition;
  } else if (now >= zoom_by_) {
    answer_ = ViscaProblem::kZoom;
    gave_up_ = true;
  }
}

void ViscaDialogue::take_fault(ViscaFault fault, int socket, MonoTime now) noexcept {
  if (fault == ViscaFault::kCancelled || fault == ViscaFault::kNoSocket) {
    const bool awaited = awaited_ == Awaited::kCancel && (socket == cancelling_ || fault == ViscaFault::kNoSocket);
    if (awaited) {
      sockets_[static_cast<std::size_t>(cancelling_)] = {};
      answered(Awaited::kCancel);
      return;
    }
  }
  if (awaited_ == Awaited::kAck) {
    take_command_refused(fault, now);
  } else if (is_move_running_in(socket)) {
    // Given up on its way, not by us: once more, after a while.
    sockets_[static_cast<std::size_t>(socket)] = {};
    if (order_.kind != ViscaOrder::Kind::kMove) return;
    done_ = false;
    refused_ = true;
    command_at_ = now + options_.retry_interval;
  } else if (awaited_ != Awaited::kNothing) {
    // Not an answer to a question; noise on the line may have spoilt it. Asked again when its time is over.
    answer_ = ViscaProblem::kRefused;
  }
}

void ViscaDialogue::take_command_refused(ViscaFault fault, MonoTime now) noexcept {
  if (step_ != Step::kReady) {
    answer_ = ViscaProblem::kRefused;
    return;
  }
  answered(Awaited::kAck);
  ++refusals_;
  if (fault == ViscaFault::kNotExecutable) {
    to_cancel_ = sockets_with(Command::kMove);
    cancels_first_ = cancels_first_ || to_cancel_ != 0;
  } else if (fault == ViscaFault::kBufferFull) {
    // An answer about a socket got lost, if none is known to be in use.
    to_cancel_ = busy_sockets() != 0 ? busy_sockets() : kEverySocket;
  }
  refused_ = to_cancel_ == 0 || refusals_ > 1;
  command_at_ = refused_ ? now + options_.retry_interval : now;
}

int ViscaDialogue::running() const noexcept { return std::popcount(busy_sockets()); }

std::uint32_t ViscaDialogue::sockets_with(Command kind) const noexcept {
  std::uint32_t found = 0;
  for (std::size_t i = 0; i < kSocketCount; ++i)
    if (sockets_[i].command == kind) found |= 1U << i;
  return found;
}

std::uint32_t ViscaDialogue::busy_sockets() const noexcept {
  return sockets_with(Command::kMove) | sockets_with(Command::kStop) | sockets_with(Command::kZoom);
}

std::uint32_t ViscaDialogue::oldest_socket() const noexcept {
  std::optional<std::size_t> oldest;
  for (std::size_t i = 0; i < kSocketCount; ++i)
    if (sockets_[i].command != Command::kNone && (!oldest || sockets_[i].age < sockets_[*oldest].age)) oldest = i;
  return oldest ? 1U << *oldest : 0;
}

bool ViscaDialogue::is_move_running_in(int socket) const noexcept {
  return sockets_[static_cast<std::size_t>(socket)].command == Command::kMove;
}

}  // namespace ninedot
