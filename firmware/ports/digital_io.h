#pragma once
/// Single digital lines. Implemented in drivers/gpio.
#include "base/result.h"

namespace ninedot {

/// Memory: none after construction. Threads: one at a time, whoever owns it: the pulse thread for a servo's line, main
/// for an indicator.
class DigitalOutput {
 public:
  /// Gives the line back to the kernel. Threads: the owner's, after the last `set`.
  virtual ~DigitalOutput() = default;
  /// One call to the kernel, which does not wait on the lines of a processor; on those of an I2C or SPI expander it
  /// waits for the bus. \error  kIo with errno: the line could not be driven
  virtual Result<void> set(bool active) noexcept = 0;
};

/// Memory: none after construction.
class DigitalInput {
 public:
  /// Threads: the owner's, when nobody asks any more. May wait for a thread of its own to end.
  virtual ~DigitalInput() = default;
  /// As last seen. Threads: any, at the same time too; never waits: for the frame path.
  virtual bool is_active() const noexcept = 0;
};

}  // namespace ninedot
