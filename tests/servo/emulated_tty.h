#pragma once
/// The far end of a serial line that can be pulled out and put back: a pseudo-terminal behind a link that keeps its
/// name, as /dev/serial/by-id has them. Whoever uses it from several threads guards it.
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace ninedot::test {

class EmulatedTty {
 public:
  EmulatedTty() {
    std::string folder = (std::filesystem::temp_directory_path() / "tty-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error("mkdtemp");
    folder_ = folder;
    plug();
  }
  ~EmulatedTty() {
    unplug();
    std::filesystem::remove_all(folder_);
  }
  EmulatedTty(const EmulatedTty&) = delete;
  EmulatedTty& operator=(const EmulatedTty&) = delete;

  std::string device() const { return folder_ + "/tty"; }
  int fd() const { return master_; }  ///< -1: pulled out

  void plug() {
    master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    std::array<char, 128> name{};
    if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0 ||
        ::ptsname_r(master_, name.data(), name.size()) != 0)
      throw std::runtime_error("no pseudo-terminal");
    termios line{};
    ::tcgetattr(master_, &line);
    ::cfmakeraw(&line);
    ::tcsetattr(master_, TCSANOW, &line);
    std::filesystem::create_symlink(name.data(), device());
  }
  /// As when a USB adapter is pulled out.
  void unplug() {
    if (master_ < 0) return;
    std::filesystem::remove(device());
    ::close(master_);
    master_ = -1;
  }

  /// What has been sent to it since; empty: nothing.
  std::vector<std::uint8_t> take() const {
    std::array<std::uint8_t, 256> buffer;
    const ssize_t got = master_ < 0 ? 0 : ::read(master_, buffer.data(), buffer.size());
    return got > 0 ? std::vector<std::uint8_t>(buffer.begin(), buffer.begin() + got) : std::vector<std::uint8_t>();
  }
  void put(std::span<const std::uint8_t> bytes) const {
    if (master_ >= 0) [[maybe_unused]]
      const auto written = ::write(master_, bytes.data(), bytes.size());
  }

  /// A millisecond, or until something has been sent. \param fd  as of a moment ago
  static void wait(int fd) {
    pollfd polled{fd, POLLIN, 0};
    // Hung up while nobody has the other end open: poll() would return at once for ever.
    if (::poll(&polled, 1, 1) > 0 && (polled.revents & POLLIN) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  std::string folder_;
  int master_ = -1;
};

}  // namespace ninedot::test
