#pragma once
/// A serial line on which one asks and another answers: noise, answers that come late, and adapters that bring back
/// what they send are all let pass.
#include <array>
#include <chrono>
#include <optional>
#include <span>

#include "base/mono_time.h"
#include "base/result.h"
#include "drivers/servo/serial_line.h"
#include "drivers/servo/servo_dialect.h"

namespace ninedot {

/// Memory: inside. Threads: one at a time for all methods.
class HalfDuplexLine {
 public:
  /// \param dialect  must outlive this
  HalfDuplexLine(SerialLine line, const ServoDialect& dialect) noexcept : line_(std::move(line)), dialect_(dialect) {}

  /// Forgets what was received, and sends. \error  kIo: the line is lost
  Result<void> send(const ServoBytes& packet) noexcept;

  /// The next answer to what was sent last. The bytes that the adapter brings back are not one.
  /// \return  none: time is over. Waits until `deadline` at most. \error  kIo: the line is lost
  Result<std::optional<ServoReply>> receive(MonoTime deadline) noexcept;

 private:
  std::optional<ServoReply> next_in_buffer() noexcept;

  SerialLine line_;
  const ServoDialect& dialect_;
  ServoBytes sent_;
  bool may_echo_ = false;
  std::array<std::uint8_t, 256> buffer_{};  // some packets and some noise; the oldest of more is dropped
  std::size_t size_ = 0;
};

}  // namespace ninedot
