#pragma once
/// A descriptor that this object closes, and the one that wakes a thread out of poll().
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>
#include <utility>

namespace ninedot {

/// Move-only; -1 is none. Memory: none. Threads: one at a time.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) noexcept : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  /// \return  the file descriptor, still owned by this object; -1: none
  int get() const noexcept { return fd_; }
  /// For a caller that wants to know whether closing works.
  /// \return  the file descriptor, the caller's from now on; -1: none
  int let_go() noexcept { return std::exchange(fd_, -1); }
  explicit operator bool() const noexcept { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

/// Readable once `ring` was called, and for ever after. Memory: none.
class WakeUp {
 public:
  WakeUp() noexcept : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  /// For poll() by whoever is to be woken. Threads: any.
  /// \return  the file descriptor; -1: none was left
  int get() const noexcept { return fd_.get(); }
  /// Threads: any, real-time ones too: one write(2) to a counter that never fills, which does not wait.
  void ring() const noexcept {
    const std::uint64_t one = 1;
    // Can't fail: the counter is far from full, and full would be readable as well.
    [[maybe_unused]] const auto written = ::write(fd_.get(), &one, sizeof one);
  }

 private:
  FileDescriptor fd_;
};

}  // namespace ninedot
