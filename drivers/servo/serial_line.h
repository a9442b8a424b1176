#pragma once
/// The serial line to a head: 8 bits, no parity, one stop bit, no flow control.
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
class SerialLine {
 public:
  /// \param baud  of kServoBaudRates (contract)
  /// \error  kIo: os_errno; ENOTTY: `device` is no serial line; EINVAL: it does not have this rate; EBUSY: another
  /// program has it
  static Result<SerialLine> open(const std::string& device, int baud) noexcept;

  SerialLine(SerialLine&&) noexcept = default;
  SerialLine& operator=(SerialLine&&) noexcept = default;
  ~SerialLine();

  /// \return  the file descriptor, for poll()
  int get() const noexcept { return fd_.get(); }
  /// \return  false: the line is lost, or it did not take the packet whole
  bool try_send(std::span<const std::uint8_t> packet) noexcept;
  /// \return  how many bytes came, possibly 0; nothing: the line is lost. Call it when poll() says POLLIN.
  std::optional<std::size_t> receive(std::span<std::uint8_t> buffer) noexcept;

  /// Forgets what has come and was not received.
  void drop_received() noexcept;

 private:
  explicit SerialLine(FileDescriptor fd) noexcept : fd_(std::move(fd)) {}
  FileDescriptor fd_;
};

}  // namespace ninedot
