#include "drivers/servo/half_duplex_line.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>

#include "drivers/posix/poll_until.h"

namespace ninedot {

Result<void> HalfDuplexLine::send(const ServoBytes& packet) noexcept {
  line_.drop_received();
  size_ = 0;
  sent_ = packet;
  may_echo_ = true;
  if (!line_.try_send(packet.span())) return fail(Errc::kIo, "the serial line is lost", errno);
  return {};
}

std::optional<ServoReply> HalfDuplexLine::next_in_buffer() noexcept {
  std::optional<ServoReply> reply;
  std::size_t at = 0;
  while (!reply && at < size_) {
    const auto rest = std::span<const std::uint8_t>(buffer_).subspan(at, size_ - at);
    const PacketLook look = dialect_.look_at(rest);
    if (look.kind == PacketLook::Kind::kIncomplete) break;
    at += look.kind == PacketLook::Kind::kWhole ? look.size : 1;
    if (look.kind == PacketLook::Kind::kNone) continue;
    const auto packet = rest.first(look.size);
    const bool is_echo = may_echo_ && std::ranges::equal(packet, sent_.span());
    may_echo_ = may_echo_ && !is_echo;
    if (!is_echo) reply = dialect_.decode(packet);
  }
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(at), buffer_.begin() + static_cast<std::ptrdiff_t>(size_),
            buffer_.begin());
  size_ -= at;
  return reply;
}

Result<std::optional<ServoReply>> HalfDuplexLine::receive(MonoTime deadline) noexcept {
  for (;;) {
    if (std::optional<ServoReply> reply = next_in_buffer()) return reply;
    if (mono_now() >= deadline) return std::nullopt;
    pollfd polled{line_.get(), POLLIN, 0};
    if (poll_until(std::span(&polled, 1), deadline) <= 0) continue;
    if ((polled.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return fail(Errc::kIo, "the serial line is lost", EIO);
    if (size_ == buffer_.size()) size_ = 0;
    const auto got = line_.receive(std::span(buffer_).subspan(size_));
    if (!got) return fail(Errc::kIo, "the serial line is lost", EIO);
    size_ += *got;
  }
}

}  // namespace ninedot
