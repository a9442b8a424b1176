#pragma once
/// Single digital lines. Implemented in drivers/gpio.
#include "base/result.h"

namespace ninedot {

/// Memory: none. Threads: one caller.
class DigitalOutput {
 public:
  /// The destructor gives the line back to the kernel.
  virtual ~DigitalOutput() = default;
  /// \error  kIo with errno: the line could not be driven
  virtual Result<void> set(bool active) noexcept = 0;
};

/// Never waits: for the frame path. Threads: any.
class DigitalInput {
 public:
  virtual ~DigitalInput() = default;
  virtual bool is_active() const noexcept = 0;
};

}  // namespace ninedot
