#pragma once
/// What writer and readers of the tap share: the mapped file, and the two lock bytes by which each knows of the other.
///
/// Open file description locks (fcntl(2), F_OFD_SETLK): a reader needs no right to write anything, and whoever dies,
/// however it dies, has given its lock up. So nothing in the file has to be believed, cleaned or aged.
#include <cstddef>
#include <cstdint>

#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// A file's bytes in memory, shared with whoever else has mapped them. Move-only. Threads: one at a time.
class SharedBytes {
 public:
  SharedBytes() = default;
  /// \param fd  open for what is asked \param size  [bytes] \param writable  else the pages are read-only
  SharedBytes(int fd, std::size_t size, bool writable) noexcept;
  SharedBytes(SharedBytes&& other) noexcept { *this = static_cast<SharedBytes&&>(other); }
  SharedBytes& operator=(SharedBytes&& other) noexcept;
  ~SharedBytes();

  /// False: the kernel refused; errno says why.
  explicit operator bool() const noexcept { return start_ != nullptr; }
  std::byte* at(std::size_t offset) const noexcept { return start_ + offset; }
  std::size_t size() const noexcept { return size_; }

 private:
  std::byte* start_ = nullptr;
  std::size_t size_ = 0;
};

enum class TapLock : std::uint8_t { kShared, kExclusive };

/// \param byte  one of the lock bytes of proto/tap_layout.h \return  whether it is ours now; never waits
bool take_tap_lock(int fd, std::int64_t byte, TapLock kind) noexcept;
/// \param byte  as above
void release_tap_lock(int fd, std::int64_t byte) noexcept;
/// Whether somebody else's lock on `byte` is in the way of one of this kind. One system call, waits for nobody.
bool is_tap_locked(int fd, std::int64_t byte, TapLock kind) noexcept;

}  // namespace ninedot
