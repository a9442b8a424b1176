#pragma once
/// The serial line to a VISCA camera: 9600 baud, 8 bits, no parity, one stop bit, no flow control.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// Open from construction to destruction; bytes not sent by then are dropped.
/// Memory: none after `open`. Threads: one at a time for all methods. Nothing here waits.
class ViscaTty {
 public:
  /// \error  kIo: os_errno; ENOTTY: `device` is no serial line; EBUSY: another program has it
  static Result<ViscaTty> open(const std::string& device) noexcept;

  ViscaTty(ViscaTty&&) noexcept = default;
  ViscaTty& operator=(ViscaTty&&) noexcept = default;
  ~ViscaTty();

  /// \return  the file descriptor, for poll()
  int get() const noexcept { return fd_.get(); }
  /// \return  false: the line is lost, or it did not take the packet whole
  bool try_send(std::span<const std::uint8_t> packet) noexcept;
  /// \return  how many bytes came, possibly 0; nothing: the line is lost. Call it when poll() says POLLIN.
  std::optional<std::size_t> receive(std::span<std::uint8_t> buffer) noexcept;

 private:
  explicit ViscaTty(FileDescriptor fd) noexcept : fd_(std::move(fd)) {}
  FileDescriptor fd_;
};

}  // namespace ninedot
