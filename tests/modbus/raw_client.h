#pragma once
/// A Modbus TCP client that can also misbehave: it sends whatever bytes it is told to.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "drivers/posix/file_descriptor.h"

namespace ninedot::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes be16(unsigned value) {
  return {static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value & 0xFFU)};
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline Bytes read_pdu(unsigned first, unsigned quantity, std::uint8_t function = 3) {
  return Bytes{function} + be16(first) + be16(quantity);
}

/// \param unit  of the MBAP header
inline Bytes tcp_frame(const Bytes& pdu, unsigned transaction = 1, std::uint8_t unit = 1) {
  return be16(transaction) + be16(0) + be16(static_cast<unsigned>(pdu.size() + 1)) + Bytes{unit} + pdu;
}

class RawClient {
 public:
  /// \param receive_buffer_bytes  0: the system's own
  explicit RawClient(std::uint16_t port, int receive_buffer_bytes = 0)
      : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (receive_buffer_bytes > 0)
      (void)::setsockopt(fd_.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
      throw std::runtime_error("connect");
    const int on = 1;
    (void)::setsockopt(fd_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }

  int fd() const { return fd_.get(); }

  void send(const Bytes& bytes) const { (void)::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  /// \return  bytes that the socket took without waiting
  long try_send(const Bytes& bytes) const {
    return ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  /// Exactly `count` bytes, or fewer when the time is over or the server hangs up.
  Bytes receive(std::size_t count, std::chrono::milliseconds timeout = std::chrono::seconds(5)) const {
    Bytes got;
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    while (got.size() < count) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
      pollfd readable{fd_.get(), POLLIN, 0};
      if (left.count() < 0 || ::poll(&readable, 1, static_cast<int>(left.count()) + 1) <= 0) break;
      std::array<std::uint8_t, 4096> chunk;
      const ssize_t n = ::recv(fd_.get(), chunk.data(), std::min(chunk.size(), count - got.size()), 0);
      if (n <= 0) break;
      got.insert(got.end(), chunk.begin(), chunk.begin() + n);
    }
    return got;
  }

  /// The PDU of the next reply; empty when none comes.
  Bytes receive_pdu(std::chrono::milliseconds timeout = std::chrono::seconds(5)) const {
    const Bytes header = receive(7, timeout);
    if (header.size() < 7) return {};
    return receive((std::size_t{header[4]} << 8U | header[5]) - 1, timeout);
  }

  Bytes ask(const Bytes& pdu) const {
    send(tcp_frame(pdu));
    return receive_pdu();
  }

  /// The server has closed this connection.
  bool is_closed(std::chrono::milliseconds timeout) const {
    pollfd readable{fd_.get(), POLLIN, 0};
    if (::poll(&readable, 1, static_cast<int>(timeout.count())) <= 0) return false;
    std::uint8_t byte;
    return ::recv(fd_.get(), &byte, 1, MSG_PEEK) <= 0;
  }

 private:
  FileDescriptor fd_;
};

/// Registers out of the PDU of a read's reply.
inline std::vector<std::uint16_t> registers_of(const Bytes& pdu) {
  std::vector<std::uint16_t> registers;
  for (std::size_t i = 2; i + 1 < pdu.size(); i += 2)
    registers.push_back(static_cast<std::uint16_t>(unsigned{pdu[i]} << 8U | pdu[i + 1]));
  return registers;
}

}  // namespace ninedot::test
