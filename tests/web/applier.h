#pragma once
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <thread>
#include <utility>

#include "drivers/posix/file_descriptor.h"

namespace ninedot::test {

/// The other end of the socket: hears one request, says what it is told to say, and hangs up when it is told to.
class Applier {
 public:
  Applier(const std::string& path, std::string answer)
      : listener_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)), answer_(std::move(answer)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    EXPECT_EQ(::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener_.get(), 4), 0);
  }
  void serve(std::size_t request_bytes) {
    thread_ = std::thread([this, request_bytes] {
      connection_ = FileDescriptor(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      std::array<char, 4096> part{};
      while (heard_.size() < request_bytes) {
        const ssize_t count = ::read(connection_.get(), part.data(), part.size());
        if (count <= 0) break;
        heard_.append(part.data(), static_cast<std::size_t>(count));
      }
      EXPECT_EQ(::send(connection_.get(), answer_.data(), answer_.size(), MSG_NOSIGNAL),
                static_cast<ssize_t>(answer_.size()));
    });
  }
  std::string heard() {
    thread_.join();
    return heard_;
  }
  void hang_up() { connection_ = FileDescriptor(); }

 private:
  FileDescriptor listener_, connection_;
  std::string answer_, heard_;
  std::thread thread_;
};

}  // namespace ninedot::test
