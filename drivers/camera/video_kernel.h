#pragma once
/// The system calls that a V4L2 camera takes, behind one seam: tests put a made-up kernel here and let it fail.
#include <cstddef>
#include <cstdint>

#include "base/mono_time.h"

namespace ninedot {

/// Every call answers with 0 or more, or with -errno. Interrupted calls are repeated inside. Threads: any, several at a
/// time on one descriptor (CameraDevice::refresh asks while `grab` takes pictures), but for `close`.
class VideoKernel {
 public:
  /// A device node for reading and writing, not blocking. \return  the file descriptor, or -errno
  virtual int open(const char* path) noexcept = 0;
  virtual void close(int fd) noexcept = 0;
  /// \param request  number of the call: VIDIOC_... [1] \return  0, or -errno
  virtual int ioctl(int fd, unsigned long request, void* argument) noexcept = 0;
  /// \return  nullptr: the mapping was refused
  virtual void* map(int fd, std::size_t bytes, std::uint32_t offset) noexcept = 0;
  virtual void unmap(void* memory, std::size_t bytes) noexcept = 0;
  /// poll() for input and priority events. \return  revents, 0: nothing until the deadline, or -errno
  virtual int wait(int fd, MonoTime deadline) noexcept = 0;

 protected:
  ~VideoKernel() = default;
};

/// The real one.
VideoKernel& linux_video_kernel() noexcept;

}  // namespace ninedot
