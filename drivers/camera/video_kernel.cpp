#include "drivers/camera/video_kernel.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace ninedot {
namespace {

class LinuxVideoKernel final : public VideoKernel {
 public:
  int open(const char* path) noexcept override {
    const int fd = ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return fd < 0 ? -errno : fd;
  }
  void close(int fd) noexcept override { ::close(fd); }
  int ioctl(int fd, unsigned long request, void* argument) noexcept override {
    for (;;) {
      if (::ioctl(fd, request, argument) >= 0) return 0;
      if (errno != EINTR) return -errno;
    }
  }
  void* map(int fd, std::size_t bytes, std::uint32_t offset) noexcept override {
    void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void unmap(void* memory, std::size_t bytes) noexcept override { ::munmap(memory, bytes); }
  int wait(int fd, MonoTime deadline) noexcept override {
    for (;;) {
      const auto left = std::max(std::chrono::nanoseconds(0), deadline - mono_now());
      const auto whole_s = std::chrono::duration_cast<std::chrono::seconds>(left);
      const timespec timeout{whole_s.count(), (left - whole_s).count()};
      pollfd descriptor{fd, POLLIN | POLLPRI, 0};
      const int count = ::ppoll(&descriptor, 1, &timeout, nullptr);
      if (count >= 0) return count == 0 ? 0 : descriptor.revents;
      if (errno != EINTR) return -errno;
    }
  }
};

}  // namespace

VideoKernel& linux_video_kernel() noexcept {
  static LinuxVideoKernel kernel;
  return kernel;
}

}  // namespace ninedot
