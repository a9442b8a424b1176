#pragma once
/// One thread sleeps until another one calls. Neither ever waits for a lock that the other holds: there is none.
#include <span>

#include "base/contract.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/poll_until.h"

namespace ninedot {

/// An eventfd. A ring is not lost: one that came before `wait_until` ends it at once; several count as one.
///
/// What is told is not in the bell: the caller stores it in atomics first, rings, and the one who wakes looks there.
/// Memory: a descriptor. Threads: see each method.
class Doorbell {
 public:
  /// No more descriptors is a bug of the set-up (contract).
  Doorbell() noexcept : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) { EXPECTS(fd_.get() >= 0); }

  /// Threads: any, in real time as well (a system call that never blocks, 0.3 us).
  void ring() const noexcept {
    const std::uint64_t one = 1;
    // Can't fail: the counter is far from full, and full would be readable as well.
    [[maybe_unused]] const auto written = ::write(fd_.get(), &one, sizeof one);
  }
  /// \return  whether it rang; looks once where `deadline` has passed. Threads: one, the one that sleeps here.
  bool wait_until(MonoTime deadline) const noexcept {
    for (;;) {
      pollfd rung{fd_.get(), POLLIN, 0};
      const int ready = poll_until(std::span(&rung, 1), deadline);
      if (ready > 0) answer();
      if (ready >= 0) return ready > 0;  // else interrupted, and the time is not over
    }
  }
  /// For poll() on several things at once; then `answer` makes it silent again. Threads: as `wait_until`, both.
  /// \return  the file descriptor, still owned by this object
  int get() const noexcept { return fd_.get(); }
  void answer() const noexcept {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(fd_.get(), &count, sizeof count);
  }

 private:
  FileDescriptor fd_;
};

}  // namespace ninedot
