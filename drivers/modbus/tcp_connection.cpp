#include "drivers/modbus/tcp_connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <utility>

#include "drivers/modbus/request.h"

namespace ninedot {
namespace {

// MBAP: transaction (2), protocol = 0 (2), length of unit and PDU (2), unit (1).
constexpr std::size_t kHeaderBytes = 7, kLengthAt = 4, kBytesBeforeUnit = 6;
constexpr std::size_t kMinLength = 2, kMaxLength = 1 + kMaxPdu;

/// A client that takes nothing for so long is gone or broken; its replies are too old to be of use.
constexpr std::chrono::seconds kUnreadReplyTimeout{5};

}  // namespace

TcpConnection::TcpConnection(FileDescriptor fd, std::string peer, MonoTime now) noexcept
    : address(std::move(peer)), opened_at(now), last_request_at(now), fd_(std::move(fd)) {}

short TcpConnection::wanted_events() const noexcept {
  short events = 0;
  if (!peer_is_done_ && in_size_ < in_.size() && has_room_for_reply()) events = POLLIN;
  // Requests beyond one round's share wait in the buffer, where poll() can't see them.
  if (out_size_ > 0 || has_complete_frame()) events = static_cast<short>(events | POLLOUT);
  return events;
}

bool TcpConnection::has_complete_frame() const noexcept {
  if (in_size_ < kHeaderBytes) return false;
  return in_size_ >= kBytesBeforeUnit + big_endian_16(std::span(in_).subspan(kLengthAt));
}

TcpConnection::Outcome TcpConnection::serve(RegisterBank& bank, short poll_events) noexcept {
  if ((poll_events & (POLLERR | POLLNVAL)) != 0) return Outcome::kClosed;
  if ((poll_events & (POLLIN | POLLHUP)) != 0 && (wanted_events() & POLLIN) != 0)
    if (const Outcome outcome = receive(); outcome != Outcome::kOpen) return outcome;
  if (const Outcome outcome = send_replies(bank.now()); outcome != Outcome::kOpen) return outcome;
  const Outcome answered = answer(bank);
  if (const Outcome outcome = send_replies(bank.now()); outcome != Outcome::kOpen) return outcome;
  if (answered != Outcome::kOpen) return answered;
  const bool nothing_left = peer_is_done_ && out_size_ == 0 && !has_complete_frame();
  return nothing_left || (poll_events & POLLHUP) != 0 ? Outcome::kClosed : Outcome::kOpen;
}

TcpConnection::Outcome TcpConnection::receive() noexcept {
  const ssize_t got = ::recv(fd_.get(), in_.data() + in_size_, in_.size() - in_size_, 0);
  if (got > 0) {
    in_size_ += static_cast<std::size_t>(got);
  } else if (got == 0) {
    peer_is_done_ = true;
  } else if (errno != EAGAIN && errno != EINTR) {
    return Outcome::kClosed;
  }
  return Outcome::kOpen;
}

TcpConnection::Outcome TcpConnection::answer(RegisterBank& bank) noexcept {
  std::size_t used = 0;
  while (has_room_for_reply() && in_size_ - used >= kHeaderBytes) {
    const std::span<const std::uint8_t> adu(in_.data() + used, in_size_ - used);
    const std::size_t length = big_endian_16(adu.subspan(kLengthAt));
    // Where the next frame starts is lost with the length; only a new connection starts afresh.
    if (big_endian_16(adu.subspan(2)) != 0 || length < kMinLength || length > kMaxLength)
      return Outcome::kProtocolError;
    if (adu.size() < kBytesBeforeUnit + length) break;

    PduBuffer reply;
    const std::size_t reply_size = answer_request(bank, session, adu.subspan(kHeaderBytes, length - 1), reply);
    std::uint8_t* out = out_.data() + out_size_;
    std::copy_n(adu.begin(), kHeaderBytes, out);
    out[kLengthAt] = 0;
    out[kLengthAt + 1] = static_cast<std::uint8_t>(reply_size + 1);
    std::copy_n(reply.begin(), reply_size, out + kHeaderBytes);
    if (out_size_ == 0) out_progress_at_ = bank.now();
    out_size_ += kHeaderBytes + reply_size;
    used += kBytesBeforeUnit + length;
    ++requests;
    last_request_at = bank.now();
  }
  std::copy(in_.begin() + static_cast<std::ptrdiff_t>(used), in_.begin() + static_cast<std::ptrdiff_t>(in_size_),
            in_.begin());
  in_size_ -= used;
  return Outcome::kOpen;
}

TcpConnection::Outcome TcpConnection::send_replies(MonoTime now) noexcept {
  if (out_size_ == 0) return Outcome::kOpen;
  const ssize_t sent = ::send(fd_.get(), out_.data(), out_size_, MSG_NOSIGNAL);
  if (sent < 0) return errno == EAGAIN || errno == EINTR ? Outcome::kOpen : Outcome::kClosed;
  std::copy(out_.begin() + sent, out_.begin() + static_cast<std::ptrdiff_t>(out_size_), out_.begin());
  out_size_ -= static_cast<std::size_t>(sent);
  out_progress_at_ = now;
  return Outcome::kOpen;
}

MonoTime TcpConnection::expires_at(std::chrono::nanoseconds idle_timeout) const noexcept {
  const MonoTime idle = last_request_at + idle_timeout;
  return out_size_ > 0 ? std::min(idle, out_progress_at_ + kUnreadReplyTimeout) : idle;
}

bool TcpConnection::is_expired(MonoTime now, std::chrono::nanoseconds idle_timeout) const noexcept {
  return now >= expires_at(idle_timeout);
}

}  // namespace ninedot
