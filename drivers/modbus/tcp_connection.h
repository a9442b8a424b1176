#pragma once
/// One TCP client: bounded buffers for what came in pieces and for what it has not read yet.
///
/// MODBUS Messaging on TCP/IP Implementation Guide V1.0b, section 3.1.3 (the MBAP header).
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/mono_time.h"
#include "drivers/modbus/register_bank.h"
#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// Memory: inside; nothing is allocated after construction. Threads: one.
class TcpConnection {
 public:
  enum class Outcome : std::uint8_t { kOpen, kClosed, kProtocolError };

  /// \param fd  non-blocking
  TcpConnection(FileDescriptor fd, std::string address, MonoTime now) noexcept;

  /// Reads once, answers what is complete, sends what the socket takes. Never waits.
  Outcome serve(RegisterBank& bank, short poll_events) noexcept;

  /// What poll() should wait for: nothing to read while the client leaves its replies lying.
  short wanted_events() const noexcept;
  int fd() const noexcept { return fd_.get(); }

  bool is_expired(MonoTime now, std::chrono::nanoseconds idle_timeout) const noexcept;
  MonoTime expires_at(std::chrono::nanoseconds idle_timeout) const noexcept;

  ClientSession session;
  const std::string address;
  const MonoTime opened_at;
  std::uint64_t requests = 0;
  MonoTime last_request_at;

 private:
  static constexpr std::size_t kMaxAdu = 260;
  static constexpr std::size_t kPipelinedReplies = 8;  // bounds one client's work per round of the server

  Outcome receive() noexcept;
  Outcome answer(RegisterBank& bank) noexcept;
  Outcome send_replies(MonoTime now) noexcept;
  bool has_complete_frame() const noexcept;
  bool has_room_for_reply() const noexcept { return out_size_ + kMaxAdu <= out_.size(); }

  FileDescriptor fd_;
  std::array<std::uint8_t, 2 * kMaxAdu> in_;
  std::size_t in_size_ = 0;
  std::array<std::uint8_t, kPipelinedReplies * kMaxAdu> out_;
  std::size_t out_size_ = 0;
  MonoTime out_progress_at_{};  // when the socket last took something while replies were waiting
  bool peer_is_done_ = false;   // it has closed its sending side
};

}  // namespace ninedot
