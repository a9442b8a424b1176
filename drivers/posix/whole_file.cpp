#include "drivers/posix/whole_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace ninedot {

ssize_t write_to_disk(int descriptor, const void* bytes, std::size_t count) noexcept {
  return ::write(descriptor, bytes, count);
}

Result<std::size_t> read_whole_file(const char* path, std::span<std::uint8_t> buffer) noexcept {
  const int descriptor = ::open(path, O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return fail(Errc::kIo, "cannot be opened", errno);
  std::size_t size = 0;
  int error = 0;
  for (;;) {
    std::uint8_t beyond = 0;  // one byte more than fits tells a file that fits exactly from one that is too long
    const bool is_full = size == buffer.size();
    const ssize_t count =
        is_full ? ::read(descriptor, &beyond, 1) : ::read(descriptor, buffer.data() + size, buffer.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) error = errno;
    if (count > 0 && is_full) error = EFBIG;
    if (count <= 0 || error != 0) break;
    size += static_cast<std::size_t>(count);
  }
  ::close(descriptor);
  if (error != 0) return fail(Errc::kIo, "cannot be read", error);
  return size;
}

Result<std::size_t> write_all(int descriptor, std::span<const std::uint8_t> bytes, WriteFunction write_bytes) noexcept {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = write_bytes(descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return fail(Errc::kIo, "cannot be written", count < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(count);
  }
  return done;
}

Result<std::size_t> write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes,
                                     WriteFunction write_bytes) {
  const std::string temporary = path + ".tmp";
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) return fail(Errc::kIo, "cannot be created", errno);
  Result<std::size_t> written = write_all(descriptor, bytes, write_bytes);
  // Network file systems report a full disk as late as here.
  if (::close(descriptor) != 0 && written) written = fail(Errc::kIo, "cannot be written", errno);
  if (written && std::rename(temporary.c_str(), path.c_str()) != 0)
    written = fail(Errc::kIo, "cannot be renamed", errno);
  if (!written) ::unlink(temporary.c_str());
  return written;
}

}  // namespace ninedot
