#pragma once
/// A line between a Modbus client and a server on which somebody else can be quicker.
#include <functional>
#include <thread>

#include "tests/modbus/raw_client.h"

namespace ninedot::test {

/// Passes on what one client at a time asks, request by request. Destroy it after the client.
class Relay {
 public:
  /// \param server  where the requests go \param before_write  called when a write (16) of the client has come and
  ///        was not passed on yet, with the address of its first register
  Relay(std::uint16_t server, std::function<void(unsigned first)> before_write)
      : server_(server), before_write_(std::move(before_write)), listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    auto* const address = reinterpret_cast<sockaddr*>(&at);
    if (::bind(listener_.get(), address, size) != 0 || ::listen(listener_.get(), 4) != 0 ||
        ::getsockname(listener_.get(), address, &size) != 0)
      throw std::runtime_error("a socket to listen on");
    port_ = ntohs(at.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  ~Relay() {
    (void)::shutdown(listener_.get(), SHUT_RDWR);
    thread_.join();
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  std::uint16_t port() const { return port_; }

 private:
  static constexpr std::size_t kHeader = 7;

  static Bytes exactly(int fd, std::size_t count) {
    Bytes bytes(count);
    if (::recv(fd, bytes.data(), count, MSG_WAITALL) != static_cast<ssize_t>(count)) bytes.clear();
    return bytes;
  }
  static Bytes frame_from(int fd) {
    const Bytes header = exactly(fd, kHeader);
    return header.empty() ? header : header + exactly(fd, (std::size_t{header[4]} << 8U | header[5]) - 1);
  }
  void run() {
    for (;;) {
      const FileDescriptor client(::accept(listener_.get(), nullptr, nullptr));
      if (client.get() < 0) return;
      const RawClient server(server_);
      for (Bytes frame = frame_from(client.get()); !frame.empty(); frame = frame_from(client.get())) {
        if (frame[kHeader] == 16) before_write_(unsigned{frame[kHeader + 1]} << 8U | frame[kHeader + 2]);
        server.send(frame);
        const Bytes reply = frame_from(server.fd());
        (void)::send(client.get(), reply.data(), reply.size(), MSG_NOSIGNAL);
      }
    }
  }

  const std::uint16_t server_;
  const std::function<void(unsigned)> before_write_;
  const FileDescriptor listener_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace ninedot::test
