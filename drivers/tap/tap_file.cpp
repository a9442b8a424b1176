#include "drivers/tap/tap_file.h"

#include <fcntl.h>
#include <sys/mman.h>

#include <utility>

namespace ninedot {
namespace {

flock lock_of(std::int64_t byte, short type) noexcept {
  flock lock{};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = static_cast<off_t>(byte);
  lock.l_len = 1;
  return lock;
}

short type_of(TapLock kind) noexcept { return kind == TapLock::kShared ? short{F_RDLCK} : short{F_WRLCK}; }

}  // namespace

SharedBytes::SharedBytes(int fd, std::size_t size, bool writable) noexcept {
  void* const start =
      ::mmap(nullptr, size, writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (start == MAP_FAILED) return;
  start_ = static_cast<std::byte*>(start);
  size_ = size;
}

SharedBytes& SharedBytes::operator=(SharedBytes&& other) noexcept {
  std::swap(start_, other.start_);
  std::swap(size_, other.size_);
  return *this;
}

SharedBytes::~SharedBytes() {
  if (start_ != nullptr) ::munmap(start_, size_);
}

bool take_tap_lock(int fd, std::int64_t byte, TapLock kind) noexcept {
  flock lock = lock_of(byte, type_of(kind));
  return ::fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

void release_tap_lock(int fd, std::int64_t byte) noexcept {
  flock lock = lock_of(byte, F_UNLCK);
  static_cast<void>(::fcntl(fd, F_OFD_SETLK, &lock));
}

bool is_tap_locked(int fd, std::int64_t byte, TapLock kind) noexcept {
  flock lock = lock_of(byte, type_of(kind));
  return ::fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

}  // namespace ninedot
